#include "compiler/views/exports/weakness_json.h"

#include <nlohmann/json.hpp>

#include "compiler/views/exports/geojson.h"
#include "compiler/views/text/weakness_text.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json position_json(const Sites& sites, const Eigen::Vector3d& p_map_m) {
  const Eigen::Vector3d p_m = sites.frame.world_m(p_map_m);
  return {p_m.x(), p_m.y(), p_m.z()};
}

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json advice_json(const TargetAdvice& advice) {
  return {{"facing_deg", facing_deg(advice.target)},
          {"beside_m", advice.beside_m},
          {"nearest_site", advice.nearest_site},
          {"return_count", advice.return_count},
          {"std_before_m", advice.std_before_m},
          {"std_after_m", advice.std_after_m},
          {"gain", advice.gain},
          {"gain_at_worst", advice.gain_at_worst}};
}

Json stretch_json(const ExplainedStretch& one) {
  const WeakStretch& stretch = one.stretch;
  return {{"run", stretch.run},
          {"from_m", stretch.from_m},
          {"to_m", stretch.to_m},
          {"first_site", stretch.first_site},
          {"last_site", stretch.last_site},
          {"unmet_sites", stretch.unmet_count},
          {"worst_site", stretch.worst_site},
          {"error_m", stretch.worst.error_m},
          {"probability", stretch.worst.probability},
          {"margin", stretch.worst.margin},
          {"look", to_text(stretch.worst.look)},
          {"place_kind", name_of(one.kind)},
          {"cause", name_of(one.cause)},
          {"reason", cause_sentence(one)},
          {"upright_count", one.sights.count},
          {"holding_count", one.sights.holding_count},
          {"nearest_holding_m", or_null(one.sights.nearest_holding_m)},
          {"one_sidedness", one.sights.one_sidedness},
          {"rival_score", or_null(one.rival_score)},
          {"loose_heading_deg", one.loose.heading_deg},
          {"off_road_deg", one.loose.off_road_deg},
          {"loose_std_m", one.loose.std_m},
          {"strong_std_m", one.loose.strong_std_m},
          {"yaw_std_rad", one.loose.yaw_rad},
          {"loose_is_of_map", one.loose.is_of_map}};
}

Result<Json> position_of(const Sites& sites, const World& world, const Eigen::Vector3d& p_map_m) {
  SIGHTLINE_ASSIGN(const GeoPosition position, geo_position(world, sites.frame.world_m(p_map_m)));
  return Json(position);
}

Json feature(Json geometry, const char* kind, const Json& properties) {
  Json named = {{"kind", kind}};
  named.update(properties);
  return {{"type", "Feature"}, {"geometry", std::move(geometry)}, {"properties", named}};
}

Result<Json> line_of(const WeakStretch& stretch, const Sites& sites, const World& world) {
  Json line = Json::array();
  for (std::size_t site = stretch.first_site; site <= stretch.last_site; ++site) {
    SIGHTLINE_ASSIGN(Json position, position_of(sites, world, sites.sites[site].p_map_m));
    line.push_back(std::move(position));
  }
  if (line.size() == 1) return Json{{"type", "Point"}, {"coordinates", line[0]}};
  return Json{{"type", "LineString"}, {"coordinates", line}};
}

}  // namespace

std::string to_json(const Weakness& weakness, const Sites& sites) {
  const TargetSize& size = weakness.options.advice.size;
  Json json = {
      {"format", "sightline-weak"},
      {"version", 1},
      {"limit_m", weakness.limit_m},
      {"least_margin", weakness.options.stretches.least_margin},
      {"join_m", weakness.options.stretches.join_m},
      {"longest_m", weakness.options.stretches.longest_m},
      {"target",
       {{"width_m", size.width_m}, {"height_m", size.height_m}, {"bottom_m", size.bottom_m}}},
      {"route_m", weakness.route_m},
      {"weak_m", weakness.weak_m},
      {"unmet_m", weakness.unmet_m},
      {"stretch_count", weakness.stretch_count},
      {"thinnest_site", weakness.thinnest_site},
      {"thinnest_margin", weakness.thinnest.margin},
      {"stretches", Json::array()}};
  for (const ExplainedStretch& one : weakness.stretches) {
    Json stretch = stretch_json(one);
    stretch["worst_world_m"] = position_json(sites, sites.sites[one.stretch.worst_site].p_map_m);
    stretch["advice"] = Json::array();
    for (const TargetAdvice& advice : one.advice) {
      Json place = {{"foot_world_m", position_json(sites, advice.target.foot_map_m)}};
      place.update(advice_json(advice));
      stretch["advice"].push_back(std::move(place));
    }
    json["stretches"].push_back(std::move(stretch));
  }
  return json_text(json);
}

Result<std::string> to_geojson(const Weakness& weakness, const Sites& sites, const World& world) {
  Json json = {{"type", "FeatureCollection"}, {"name", "weak"}};
  // Of a file without it programs believe that it holds degrees.
  if (world.kind == WorldKind::kLocal) {
    json["crs"] = {{"type", "name"}, {"properties", {{"name", kLocalCrsWkt}}}};
  }
  json["features"] = Json::array();
  for (std::size_t i = 0; i < weakness.stretches.size(); ++i) {
    const ExplainedStretch& one = weakness.stretches[i];
    SIGHTLINE_ASSIGN(Json line, line_of(one.stretch, sites, world));
    Json properties = {{"stretch", i + 1}};
    properties.update(stretch_json(one));
    json["features"].push_back(feature(std::move(line), "stretch", properties));
    for (std::size_t rank = 0; rank < one.advice.size(); ++rank) {
      const TargetAdvice& advice = one.advice[rank];
      SIGHTLINE_ASSIGN(Json position, position_of(sites, world, advice.target.foot_map_m));
      Json place = {{"stretch", i + 1}, {"rank", rank + 1}};
      place.update(advice_json(advice));
      json["features"].push_back(
          feature({{"type", "Point"}, {"coordinates", position}}, "advice", place));
    }
  }
  return json_text(json, -1) + "\n";
}

}  // namespace sightline
