#include "compiler/views/exports/foxglove_mcap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "compiler/views/exports/export_frame.h"
#include "compiler/views/exports/foxglove_schemas.h"
#include "compiler/views/exports/geojson.h"
#include "compiler/views/picture/raster.h"
#include "formats/annotation/range_rule.h"
#include "formats/foreign/ros/files/mcap_writer.h"
#include "formats/release/base64.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFrame = "map";
constexpr double kSpeed_m_s = 10.0;
constexpr std::int64_t kFirst_ns = 1'000'000'000;  // programs take 0 as no time
constexpr double kSite_m = 0.6;  // diameter of a site's sphere: seen from a street
constexpr double kRoute_px = 5.0;

Json time_of(std::int64_t time_ns) {
  return {{"sec", time_ns / 1'000'000'000}, {"nsec", time_ns % 1'000'000'000}};
}

Json to_json(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

Json to_json(const Eigen::Quaterniond& q) {
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}

Json to_json(const Pose& pose) {
  return {{"position", to_json(Eigen::Vector3d(pose.translation()))},
          {"orientation", to_json(Eigen::Quaterniond(pose.linear()))}};
}

Pose at(const Eigen::Vector3d& p_m) {
  Pose pose = Pose::Identity();
  pose.translation() = p_m;
  return pose;
}

Json to_json(const Colour& colour) {
  return {{"r", colour.red / 255.0},
          {"g", colour.green / 255.0},
          {"b", colour.blue / 255.0},
          {"a", 1.0}};
}

std::string text_of(const SiteProperty& value) {
  return std::visit([](const auto& plain) { return Json(plain).dump(); }, value);
}

Json entity(const std::string& id) {
  Json entity = {{"timestamp", time_of(kFirst_ns)},
                 {"frame_id", kFrame},
                 {"id", id},
                 {"lifetime", {{"sec", 0}, {"nsec", 0}}},  // for ever
                 {"frame_locked", true}};
  for (const char* list : {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines",
                           "triangles", "texts", "models"}) {
    entity[list] = Json::array();
  }
  return entity;
}

// Adds topics and messages of a map.
class FoxgloveFile {
 public:
  FoxgloveFile(const CompiledMap& map, const World& world, const ByteSink& sink)
      : map_(map), world_(world), shift_m_(export_shift_m(map.ndt.frame)), writer_(sink, "") {
    std::int64_t time_ns = kFirst_ns;
    const std::vector<Site>& sites = map.sites.sites;
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const bool is_next = i > 0 && sites[i].run == sites[i - 1].run;
      const double way_m = is_next ? sites[i].s_m - sites[i - 1].s_m : map.sites.spacing_m;
      if (i > 0) time_ns += std::llround(way_m / kSpeed_m_s * 1e9);
      times_ns_.push_back(time_ns);
    }
  }

  Result<void> write() {
    SIGHTLINE_TRY(add_once("/map/nds", foxglove_point_cloud_schema(), nds()));
    SIGHTLINE_TRY(add_once("/map/route", foxglove_scene_update_schema(), route()));
    SIGHTLINE_TRY(add_once("/map/sites", foxglove_scene_update_schema(), sites()));
    SIGHTLINE_TRY(add_once("/drive", foxglove_poses_in_frame_schema(), drive()));
    SIGHTLINE_TRY(add_each_site());
    return writer_.finish();
  }

 private:
  std::uint16_t topic(const std::string& name, const Json& schema) {
    const std::string text = json_text(schema, -1);
    return writer_.add_topic(
        name, {schema["title"].get_ref<const std::string&>(), text, "jsonschema", "json"});
  }

  Result<void> add(std::uint16_t topic, std::int64_t time_ns, const Json& message) {
    const std::string text = json_text(message, -1);
    return writer_.add(topic, time_ns, std::as_bytes(std::span(text)));
  }

  Result<void> add_once(const std::string& name, const Json& schema, const Json& message) {
    return add(topic(name, schema), kFirst_ns, message);
  }

  [[nodiscard]] Pose T_export_vehicle(const Site& site) const {
    return at(shift_m_) * site.T_map_vehicle;
  }

  // By the range at the tightest limit.
  [[nodiscard]] Json colour_of(std::size_t site) const {
    const double range_m = answer_of(map_.ranges, map_.predicted, site, 0).look.range_m;
    const std::vector<Look>& looks = map_.ranges.looks;
    const auto found = std::ranges::find(looks, range_m, &Look::range_m);
    return to_json(
        range_colour_on_paper(static_cast<std::size_t>(found - looks.begin()), looks.size()));
  }

  [[nodiscard]] Json nds() const {
    Json fields = Json::array();
    for (const char* name : {"x", "y", "z", "deviation_1_m", "deviation_2_m", "deviation_3_m",
                             "dimension", "points"}) {
      constexpr int kFloat32 = 7;
      fields.push_back({{"name", name}, {"offset", 4 * fields.size()}, {"type", kFloat32}});
    }
    ByteWriter data;
    for (const Nd& nd : map_.ndt.nds) {
      const Eigen::Vector3d p_m = nd.mean_m + shift_m_;
      for (int axis = 0; axis < 3; ++axis) data.put(static_cast<float>(p_m[axis]));
      for (int axis = 0; axis < 3; ++axis) {
        data.put(static_cast<float>(std::sqrt(nd.eigenvalues_m2[axis])));
      }
      data.put(static_cast<float>(dimension_class(nd)));
      data.put(static_cast<float>(nd.point_count));
    }
    return {{"timestamp", time_of(kFirst_ns)},
            {"frame_id", kFrame},
            {"pose", to_json(Pose(Pose::Identity()))},
            {"point_stride", 4 * fields.size()},
            {"fields", fields},
            {"data", base64_of(data.bytes())}};
  }

  // A line for each run.
  [[nodiscard]] Json route() const {
    Json entities = Json::array();
    const std::vector<Site>& sites = map_.sites.sites;
    for (std::size_t i = 0; i < sites.size(); ++i) {
      if (i == 0 || sites[i].run != sites[i - 1].run) {
        entities.push_back(entity("run " + std::to_string(sites[i].run)));
        entities.back()["lines"].push_back({{"type", 0},
                                            {"pose", to_json(Pose(Pose::Identity()))},
                                            {"thickness", kRoute_px},
                                            {"scale_invariant", true},
                                            {"points", Json::array()},
                                            {"color", to_json(Colour{})},
                                            {"colors", Json::array()},
                                            {"indices", Json::array()}});
      }
      Json& line = entities.back()["lines"].front();
      line["points"].push_back(to_json(Eigen::Vector3d(T_export_vehicle(sites[i]).translation())));
      line["colors"].push_back(colour_of(i));
    }
    return {{"deletions", Json::array()}, {"entities", std::move(entities)}};
  }

  [[nodiscard]] Json sites() const {
    Json entities = Json::array();
    for (std::size_t i = 0; i < map_.sites.sites.size(); ++i) {
      Json site = entity("site " + std::to_string(i));
      for (const auto& [name, value] : site_properties(map_, i)) {
        site["metadata"].push_back({{"key", name}, {"value", text_of(value)}});
      }
      site["spheres"].push_back(
          {{"pose", to_json(at(map_.sites.sites[i].p_map_m + shift_m_))},
           {"size", to_json(Eigen::Vector3d(Eigen::Vector3d::Constant(kSite_m)))},
           {"color", colour_of(i)}});
      entities.push_back(std::move(site));
    }
    return {{"deletions", Json::array()}, {"entities", std::move(entities)}};
  }

  [[nodiscard]] Json drive() const {
    Json poses = Json::array();
    for (const Site& site : map_.sites.sites) poses.push_back(to_json(T_export_vehicle(site)));
    return {{"timestamp", time_of(kFirst_ns)}, {"frame_id", kFrame}, {"poses", std::move(poses)}};
  }

  [[nodiscard]] Json site_schema() const {
    Json properties = Json::object();
    if (!map_.sites.sites.empty()) {
      for (const auto& [name, value] : site_properties(map_, 0)) {
        constexpr const char* kTypes[] = {"boolean", "integer", "number", "string"};
        properties[name] = {{"type", kTypes[value.index()]}};
      }
    }
    return {{"title", "sightline.Site"}, {"type", "object"}, {"properties", properties}};
  }

  Result<void> add_each_site() {
    const std::uint16_t tf = topic("/tf", foxglove_frame_transform_schema());
    const std::uint16_t pose = topic("/pose", foxglove_pose_in_frame_schema());
    const std::uint16_t numbers = topic("/site", site_schema());
    const bool is_on_earth = world_.kind != WorldKind::kLocal;
    const std::uint16_t fix = is_on_earth ? topic("/fix", foxglove_location_fix_schema()) : 0;
    for (std::size_t i = 0; i < map_.sites.sites.size(); ++i) {
      const std::int64_t time_ns = times_ns_[i];
      SIGHTLINE_TRY(add(tf, time_ns, transform(i)));
      SIGHTLINE_TRY(add(pose, time_ns,
                        {{"timestamp", time_of(time_ns)},
                         {"frame_id", kFrame},
                         {"pose", to_json(T_export_vehicle(map_.sites.sites[i]))}}));
      Json site = Json::object();
      for (const auto& [name, value] : site_properties(map_, i)) {
        site[name] = std::visit([](const auto& plain) { return Json(plain); }, value);
      }
      SIGHTLINE_TRY(add(numbers, time_ns, site));
      if (!is_on_earth) continue;
      SIGHTLINE_ASSIGN(const Json position, fix_at(i));
      SIGHTLINE_TRY(add(fix, time_ns, position));
    }
    return {};
  }

  [[nodiscard]] Json transform(std::size_t i) const {
    const Pose T_map_vehicle = T_export_vehicle(map_.sites.sites[i]);
    return {{"timestamp", time_of(times_ns_[i])},
            {"parent_frame_id", kFrame},
            {"child_frame_id", "vehicle"},
            {"translation", to_json(Eigen::Vector3d(T_map_vehicle.translation()))},
            {"rotation", to_json(Eigen::Quaterniond(T_map_vehicle.linear()))}};
  }

  [[nodiscard]] Result<Json> fix_at(std::size_t i) const {
    SIGHTLINE_ASSIGN(const GeoPosition position,
                     geo_position(world_, map_.sites.frame.world_m(map_.sites.sites[i].p_map_m)));
    return Json{{"timestamp", time_of(times_ns_[i])},
                {"frame_id", "vehicle"},
                {"latitude", position[1]},
                {"longitude", position[0]},
                {"altitude", position[2]},
                {"position_covariance", std::vector<double>(9, 0.0)},
                {"position_covariance_type", 0}};  // unknown
  }

  const CompiledMap& map_;
  const World& world_;
  Eigen::Vector3d shift_m_;  // from map coordinates to those of the file
  McapWriter writer_;
  std::vector<std::int64_t> times_ns_;  // by site
};

}  // namespace

Result<void> write_foxglove_mcap(const CompiledMap& map, const World& world, const ByteSink& sink) {
  return FoxgloveFile(map, world, sink).write();
}

}  // namespace sightline
