#include "compiler/views/exports/geojson.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

// Nine decimals of a degree are a tenth of a millimetre.
double rounded_deg(double value) { return std::round(value * 1e9) / 1e9; }

Result<Json> position_of(const CompiledMap& map, const World& world, const Site& site) {
  const Eigen::Vector3d p_world_m = site.p_map_m + map.sites.frame.origin_world_m;
  if (world.kind == WorldKind::kLocal) {
    return Json::array({p_world_m.x(), p_world_m.y(), p_world_m.z()});
  }
  SIGHTLINE_ASSIGN(const Geodetic point, to_geodetic(world, p_world_m));
  return Json::array(
      {rounded_deg(point.longitude_deg), rounded_deg(point.latitude_deg), point.altitude_m});
}

Json feature(const char* type, const Json& coordinates, const Json& properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", coordinates}}},
          {"properties", properties}};
}

Json properties_of(const CompiledMap& map, std::size_t index) {
  const Site& site = map.sites.sites[index];
  Json properties = {{"site", index}, {"run", site.run}, {"s_m", site.s_m}};
  const std::size_t limits = map.ranges.promises.size();
  for (std::size_t limit = 0; limit < limits; ++limit) {
    const std::string within =
        "_within_" + format_double(map.ranges.promises[limit].limit_m) + "_m";
    const std::size_t range = map.ranges.range(index, limit);
    const std::uint8_t flags = map.ranges.flags_of(index, limit);
    properties["range_m" + within] = map.ranges.looks[range].range_m;
    properties["p" + within] = map.predicted.probability(index, range, limit);
    properties["error_m" + within] = map.predicted.mean(index, range);
    properties["unmet" + within] = (flags & kUnmet) != 0;
    properties["extrapolated" + within] = (flags & kExtrapolated) != 0;
    properties["static" + within] = (flags & kStatic) != 0;
    for (const RangeTable& looks : map.ranges.of_samples) {
      const std::size_t look = looks.range(index, limit);
      properties["look" + within] = to_text(looks.looks[look]);
      properties["look_p" + within] =
          map.predicted.of_samples.front().probability(index, look, limit);
      properties["look_static" + within] = (looks.flags_of(index, limit) & kStatic) != 0;
    }
  }
  return properties;
}

}  // namespace

Result<std::string> to_geojson(const CompiledMap& map, const World& world) {
  Json features = Json::array();
  Json line = Json::array();
  for (std::size_t i = 0; i < map.sites.sites.size(); ++i) {
    const Site& site = map.sites.sites[i];
    SIGHTLINE_ASSIGN(const Json position, position_of(map, world, site));
    line.push_back(position);
    features.push_back(feature("Point", position, properties_of(map, i)));
    const bool ends = i + 1 == map.sites.sites.size() || map.sites.sites[i + 1].run != site.run;
    if (!ends) continue;
    // A line has two points at least.
    if (line.size() > 1) features.push_back(feature("LineString", line, {{"run", site.run}}));
    line = Json::array();
  }
  const Json all = {{"type", "FeatureCollection"}, {"name", map.map_id}, {"features", features}};
  return all.dump() + "\n";
}

}  // namespace sightline
