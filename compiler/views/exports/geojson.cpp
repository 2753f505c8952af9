#include "compiler/views/exports/geojson.h"

#include <nlohmann/json.hpp>

#include "compiler/views/exports/geo_position.h"
#include "compiler/views/exports/site_properties.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Result<Json> position_of(const CompiledMap& map, const World& world, const Site& site) {
  const Eigen::Vector3d p_world_m = site.p_map_m + map.sites.frame.origin_world_m;
  SIGHTLINE_ASSIGN(const GeoPosition position, geo_position(world, p_world_m));
  return Json(position);
}

Json feature(const char* type, const Json& coordinates, const Json& properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", coordinates}}},
          {"properties", properties}};
}

Json properties_of(const CompiledMap& map, std::size_t index) {
  Json properties = Json::object();
  for (const auto& [name, value] : site_properties(map, index)) {
    properties[name] = std::visit([](const auto& plain) { return Json(plain); }, value);
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
  Json all = {{"type", "FeatureCollection"}, {"name", map.map_id}};
  // Of a file without it programs believe that it holds degrees.
  if (world.kind == WorldKind::kLocal) {
    all["crs"] = {{"type", "name"}, {"properties", {{"name", kLocalCrsWkt}}}};
  }
  all["features"] = std::move(features);
  return all.dump() + "\n";
}

}  // namespace sightline
