#include "compiler/views/exports/foxglove_mcap.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "compiler/views/exports/export_frame.h"
#include "compiler/views/exports/foxglove_schemas.h"
#include "compiler/views/exports/geojson.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/json_schema.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

std::string exported(const CompiledMap& map, const World& world) {
  std::string bytes;
  const ByteSink sink = [&](std::span<const std::byte> more) -> Result<void> {
    bytes.append(reinterpret_cast<const char*>(more.data()), more.size());
    return {};
  };
  EXPECT_TRUE(write_foxglove_mcap(map, world, sink).has_value());
  return bytes;
}

// The messages of a file that begin with this: chunks are not packed.
std::vector<Json> messages_with(const std::string& file, const std::string& begin) {
  std::vector<Json> found;
  for (std::size_t at = file.find(begin); at != std::string::npos;
       at = file.find(begin, at + begin.size())) {
    int depth = 0;
    std::size_t end = at;
    do {
      depth += file[end] == '{' ? 1 : file[end] == '}' ? -1 : 0;
    } while (++end < file.size() && depth > 0);
    found.push_back(Json::parse(file.substr(at, end - at)));
  }
  return found;
}

std::vector<Json> sites_of(const std::string& file) {
  std::vector<Json> sites = messages_with(file, "{\"site\":");
  std::erase_if(sites, [](const Json& site) { return !site["site"].is_number(); });  // the schema
  return sites;
}

TEST(FoxgloveMcap, HasTheAnswersOfEachSiteInTheirOrder) {
  const CompiledMap map = random_map({.seed = 5});
  const std::string file = exported(map, World{});
  const std::vector<Json> sites = sites_of(file);
  ASSERT_EQ(sites.size(), map.sites.sites.size());
  for (std::size_t i = 0; i < sites.size(); ++i) {
    EXPECT_EQ(sites[i]["site"], i);
    EXPECT_EQ(sites[i]["s_m"], map.sites.sites[i].s_m);
    EXPECT_TRUE(sites[i]["range_m_within_10_cm"].is_number());
  }
}

TEST(FoxgloveMcap, DrivesAtTenMetresASecondInTheCoordinatesOfExports) {
  const CompiledMap map = random_map({.seed = 5});
  const std::string file = exported(map, World{});
  const Json schema = foxglove_frame_transform_schema();
  std::vector<Json> tf;
  for (const Json& message : messages_with(file, "{\"timestamp\":{\"sec\":")) {
    if (message.contains("child_frame_id")) tf.push_back(message);
  }
  ASSERT_EQ(tf.size(), map.sites.sites.size());
  for (std::size_t i = 0; i < tf.size(); ++i) {
    EXPECT_EQ(schema_faults(schema, tf[i]), "");
    const Eigen::Vector3d p_m =
        map.sites.sites[i].T_map_vehicle.translation() + export_shift_m(map.sites.frame);
    EXPECT_EQ(tf[i]["translation"]["x"], p_m.x());
    EXPECT_EQ(tf[i]["translation"]["y"], p_m.y());
  }
  const auto seconds = [](const Json& message) {
    return message["timestamp"]["sec"].get<double>() +
           1e-9 * message["timestamp"]["nsec"].get<double>();
  };
  EXPECT_EQ(seconds(tf[0]), 1.0);
  EXPECT_NEAR(seconds(tf[1]) - 1.0, 0.1 * (map.sites.sites[1].s_m - map.sites.sites[0].s_m), 1e-9);
}

TEST(FoxgloveMcap, GivesTheSameBytesForTheSameMap) {
  const CompiledMap map = random_map({.seed = 6});
  EXPECT_EQ(exported(map, World{}), exported(map, World{}));
}

TEST(FoxgloveMcap, HasPlacesOnEarthWhereTheWorldIsKnown) {
  const CompiledMap map = random_map({.seed = 5});
  EXPECT_EQ(exported(map, World{}).find("LocationFix"), std::string::npos);
  std::vector<Json> fixes;
  const World world = value_of(parse_world("enu:48.98,8.39,116.4"));
  const std::string file = exported(map, world);
  for (const Json& message : messages_with(file, "{\"timestamp\":{\"sec\":")) {
    if (message.contains("latitude")) fixes.push_back(message);
  }
  ASSERT_EQ(fixes.size(), map.sites.sites.size());
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    EXPECT_EQ(schema_faults(foxglove_location_fix_schema(), fixes[i]), "");
    const GeoPosition position =
        value_of(geo_position(world, map.sites.frame.world_m(map.sites.sites[i].p_map_m)));
    EXPECT_EQ(fixes[i]["longitude"], position[0]);
    EXPECT_EQ(fixes[i]["latitude"], position[1]);
  }
}

}  // namespace
}  // namespace sightline
