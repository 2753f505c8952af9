#include "compiler/views/exports/geojson.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/annotation/range_rule.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Result<Json> position_of(const CompiledMap& map, const World& world, const Site& site) {
  const Eigen::Vector3d p_world_m = map.sites.frame.world_m(site.p_map_m);
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

// Nine decimals of a degree are a tenth of a millimetre.
double rounded_deg(double value) { return std::round(value * 1e9) / 1e9; }

using Properties = std::vector<std::pair<std::string, SiteProperty>>;

// Without a dot, which SQL and expressions of QGIS read as another name.
std::string within(const CompiledMap& map, std::size_t limit) {
  std::string limit_cm = format_double(std::round(map.ranges.promises[limit].limit_m * 1e5) / 1e3);
  std::ranges::replace(limit_cm, '.', '_');
  return concat("_within_", limit_cm, "_cm");
}

void add_look(const CompiledMap& map, std::size_t site, std::size_t limit, Properties& properties) {
  const Answer answer = answer_of(map.looks->ranges, map.looks->predicted, site, limit);
  const std::string suffix = within(map, limit);
  properties.emplace_back("look" + suffix, to_text(answer.look));
  properties.emplace_back("look_p" + suffix, answer.probability);
  properties.emplace_back("look_static" + suffix, (answer.flags & kStatic) != 0);
  properties.emplace_back("look_reason" + suffix, std::string(name_of(answer.reason)));
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
  return json_text(all, -1) + "\n";
}

Result<GeoPosition> geo_position(const World& world, const Eigen::Vector3d& p_world_m) {
  if (world.kind == WorldKind::kLocal) {
    return GeoPosition{p_world_m.x(), p_world_m.y(), p_world_m.z()};
  }
  SIGHTLINE_ASSIGN(const Geodetic point, to_geodetic(world, p_world_m));
  return GeoPosition{rounded_deg(point.longitude_deg), rounded_deg(point.latitude_deg),
                     point.altitude_m};
}

std::string range_property(const CompiledMap& map, std::size_t limit) {
  return "range_m" + within(map, limit);
}

Properties site_properties(const CompiledMap& map, std::size_t site) {
  const Site& at = map.sites.sites[site];
  Properties properties = {
      {"site", static_cast<std::int64_t>(site)}, {"run", std::int64_t{at.run}}, {"s_m", at.s_m}};
  // The same columns at all places of a map.
  const bool is_annotated = std::ranges::find(map.definitions, "annotating-a-finished-map",
                                              &NamedVersion::name) != map.definitions.end();
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    const std::string suffix = within(map, limit);
    const Answer answer = answer_of(map.ranges, map.predicted, site, limit);
    properties.emplace_back("range_m" + suffix, answer.look.range_m);
    properties.emplace_back("p" + suffix, answer.probability);
    properties.emplace_back("error_m" + suffix, answer.error_m);
    properties.emplace_back("unmet" + suffix, (answer.flags & kUnmet) != 0);
    properties.emplace_back("extrapolated" + suffix, (answer.flags & kExtrapolated) != 0);
    properties.emplace_back("static" + suffix, (answer.flags & kStatic) != 0);
    if (is_annotated) {
      properties.emplace_back("simulated" + suffix, (answer.flags & kSimulatedAnswer) != 0);
    }
    properties.emplace_back("reason" + suffix, std::string(name_of(answer.reason)));
    if (map.looks) add_look(map, site, limit, properties);
  }
  for (const SiteColumn& column : map.columns) {
    properties.emplace_back(column.name, double{column.values[site]});
  }
  return properties;
}

}  // namespace sightline
