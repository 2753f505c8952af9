#include "compiler/views/text/map_diff_json.h"

#include <array>
#include <nlohmann/json.hpp>

#include "formats/text/json_text.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 3> kSiteChanges = {"added", "removed", "changed"};
constexpr std::array<const char*, 3> kNdChanges = {"added", "removed", "moved"};

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json position_json(const Eigen::Vector3d& p_m) { return {p_m.x(), p_m.y(), p_m.z()}; }

Json map_json(const DiffedMap& map) {
  return {{"map_id", map.map_id},         {"version", map.version},
          {"release", map.release},       {"root_digest", to_hex(map.root_digest)},
          {"nd_count", map.nd_count},     {"site_count", map.site_count},
          {"tile_count", map.tile_count}, {"file_size", map.file_size}};
}

Json quality_json(const std::optional<LimitQuality>& quality) {
  if (!quality) return {};
  return {{"unmet_count", quality->unmet_count},
          {"extrapolated_count", quality->extrapolated_count},
          {"mean_range_m", quality->mean_range_m},
          {"expected_coverage", quality->expected_coverage},
          {"measured_coverage", quality->measured_coverage}};
}

Json limit_json(const LimitDiff& limit) {
  return {{"limit_m", limit.limit_m},
          {"before", quality_json(limit.before)},
          {"after", quality_json(limit.after)},
          {"rose", limit.rose},
          {"fell", limit.fell},
          {"newly_unmet", limit.newly_unmet},
          {"no_longer_unmet", limit.no_longer_unmet},
          {"work_before", limit.work_before ? Json(*limit.work_before) : Json()},
          {"work_after", limit.work_after ? Json(*limit.work_after) : Json()}};
}

Json answer_json(double limit_m, const AnswerDiff& answer) {
  const auto answer_json = [](const SiteAnswer& of_map) {
    return Json{{"range_m", of_map.range_m},
                {"is_unmet", of_map.is_unmet()},
                {"is_extrapolated", (of_map.flags & kExtrapolated) != 0},
                {"reason", name_of(of_map.reason)},
                {"probability", of_map.probability}};
  };
  return {{"limit_m", limit_m},
          {"before", answer_json(answer.before)},
          {"after", answer_json(answer.after)}};
}

Json site_json(const SiteDiff& site, const std::vector<double>& limits_m) {
  Json json = {{"change", kSiteChanges[static_cast<std::size_t>(site.change)]},
               {"site", site.site},
               {"run", site.run},
               {"s_m", site.s_m},
               {"p_world_m", position_json(site.p_world_m)},
               {"distance_m", site.distance_m},
               {"answers", Json::array()}};
  for (std::size_t i = 0; i < site.answers.size(); ++i) {
    json["answers"].push_back(answer_json(limits_m[i], site.answers[i]));
  }
  return json;
}

Json stretch_json(const Stretch& stretch, const std::vector<double>& limits_m) {
  Json json = {{"is_of_old_map", stretch.is_of_old_map},
               {"has_changed_place", stretch.has_changed_place},
               {"run", stretch.run},
               {"begin_s_m", stretch.begin_s_m},
               {"end_s_m", stretch.end_s_m},
               {"first_site", stretch.first_site},
               {"last_site", stretch.last_site},
               {"begin_world_m", position_json(stretch.line_world_m.front())},
               {"end_world_m", position_json(stretch.line_world_m.back())},
               {"nds_added", stretch.nds_added},
               {"nds_removed", stretch.nds_removed},
               {"nds_moved", stretch.nds_moved},
               {"sites_added", stretch.sites_added},
               {"sites_removed", stretch.sites_removed},
               {"limits", Json::array()}};
  for (std::size_t i = 0; i < stretch.limits.size(); ++i) {
    const StretchLimit& limit = stretch.limits[i];
    json["limits"].push_back({{"limit_m", limits_m[i]},
                              {"rose", limit.rose},
                              {"fell", limit.fell},
                              {"newly_unmet", limit.newly_unmet},
                              {"no_longer_unmet", limit.no_longer_unmet},
                              {"mean_range_before_m", limit.mean_range_before_m},
                              {"mean_range_after_m", limit.mean_range_after_m}});
  }
  return json;
}

Result<Json> geo_position(const World& world, const Eigen::Vector3d& p_m) {
  if (world.kind == WorldKind::kLocal) return position_json(p_m);
  SIGHTLINE_ASSIGN(const Geodetic p, to_geodetic(world, p_m));
  return Json{p.longitude_deg, p.latitude_deg, p.altitude_m};
}

// A line through places, or a point where there is one.
Result<Json> geometry_of(const World& world, const std::vector<Eigen::Vector3d>& line_m) {
  Json positions = Json::array();
  for (const Eigen::Vector3d& p_m : line_m) {
    SIGHTLINE_ASSIGN(Json position, geo_position(world, p_m));
    positions.push_back(std::move(position));
  }
  if (line_m.size() == 1) return Json{{"type", "Point"}, {"coordinates", positions[0]}};
  return Json{{"type", "LineString"}, {"coordinates", positions}};
}

// A part of a diff, its places in world coordinates.
struct Feature {
  const char* kind = "";
  std::vector<Eigen::Vector3d> line_m;
  Json properties;
};

std::vector<Feature> features_of(const MapDiff& diff) {
  const std::vector<double> limits_m = common_limits_m(diff);
  std::vector<Feature> features;
  for (const Stretch& stretch : diff.stretches) {
    features.push_back({"stretch", stretch.line_world_m, stretch_json(stretch, limits_m)});
  }
  for (const SiteDiff& site : diff.sites) {
    features.push_back({"site", {site.p_world_m}, site_json(site, limits_m)});
  }
  for (const NdDiff& nd : diff.nds) {
    features.push_back(
        {"nd",
         {nd.mean_world_m},
         {{"change", kNdChanges[static_cast<std::size_t>(nd.change)]}, {"moved_m", nd.moved_m}}});
  }
  return features;
}

}  // namespace

std::string to_json(const MapDiff& diff) {
  const std::vector<double> limits_m = common_limits_m(diff);
  Json json = {{"format", "sightline-diff"},
               {"version", 1},
               {"is_same", diff.is_same()},
               {"tolerance_m", diff.options.tolerance_m},
               {"join_m", diff.options.join_m},
               {"longest_m", diff.options.longest_m},
               {"bytes_read", diff.bytes_read},
               {"before", map_json(diff.before)},
               {"after", map_json(diff.after)},
               {"facts", Json::array()},
               {"blocks", Json::array()},
               {"tiles",
                {{"added", diff.tiles_added},
                 {"removed", diff.tiles_removed},
                 {"changed", diff.tiles_changed}}},
               {"nds",
                {{"is_comparable", diff.has_comparable_nds},
                 {"added", diff.nds_added},
                 {"removed", diff.nds_removed},
                 {"moved", diff.nds_moved},
                 {"off_route", diff.nds_off_route},
                 {"scattered", diff.nds_scattered}}},
               {"limits", Json::array()},
               {"stretches", Json::array()},
               {"sites", Json::array()}};
  for (const FactDiff& fact : diff.facts) {
    json["facts"].push_back({{"name", fact.name},
                             {"before", text_or_null(fact.before)},
                             {"after", text_or_null(fact.after)}});
  }
  for (const BlockDiff& block : diff.blocks) {
    json["blocks"].push_back({{"name", block.name},
                              {"is_required", block.is_required},
                              {"added", block.added},
                              {"removed", block.removed},
                              {"changed", block.changed},
                              {"same", block.same}});
  }
  for (const LimitDiff& limit : diff.limits) json["limits"].push_back(limit_json(limit));
  for (const Stretch& stretch : diff.stretches) {
    json["stretches"].push_back(stretch_json(stretch, limits_m));
  }
  for (const SiteDiff& site : diff.sites) json["sites"].push_back(site_json(site, limits_m));
  // Names come from the maps: bytes that are no UTF-8 are replaced, not a reason to fail.
  return json_text(json);
}

Result<std::string> to_geojson(const MapDiff& diff, const World& world) {
  Json json = {{"type", "FeatureCollection"},
               {"coordinate_frame",
                world.kind == WorldKind::kLocal
                    ? "metres x, y, z of the recording's own world, not longitude and latitude"
                    : "WGS 84: longitude, latitude (degrees), height of the recording (m)"},
               {"features", Json::array()}};
  if (world.kind == WorldKind::kLocal) {
    // Of a file without it programs believe that it holds degrees.
    json["crs"] = {{"type", "name"}, {"properties", {{"name", kLocalCrsWkt}}}};
  }
  for (const Feature& feature : features_of(diff)) {
    SIGHTLINE_ASSIGN(Json geometry, geometry_of(world, feature.line_m));
    Json properties = {{"kind", feature.kind}};
    properties.update(feature.properties);
    json["features"].push_back({{"type", "Feature"},
                                {"geometry", std::move(geometry)},
                                {"properties", std::move(properties)}});
  }
  return json_text(json, -1) + "\n";
}

}  // namespace sightline
