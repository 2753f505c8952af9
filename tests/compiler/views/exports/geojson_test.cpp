#include "compiler/views/exports/geojson.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/formats/map/random_map.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

TEST(GeoJson, AgreesWithTheDumpAtEverySite) {
  const CompiledMap map = random_map({.seed = 5});
  const Json json = Json::parse(*to_geojson(map, World{}));
  const Table table = dump(map);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::ranges::find(table.columns, name) - table.columns.begin());
  };
  std::size_t sites = 0;
  std::size_t lines = 0;
  for (const Json& feature : json["features"]) {
    if (feature["geometry"]["type"] == "LineString") {
      ++lines;
      continue;
    }
    const Json& properties = feature["properties"];
    const std::vector<Cell>& row = table.rows[sites];
    EXPECT_EQ(properties["site"], sites);
    for (const auto& [name, dumped] :
         {std::pair{"range_m_within_10_cm", "range_m_within_0.1_m"},
          std::pair{"p_within_10_cm", "p_within_0.1_m"},
          std::pair{"range_m_within_25_cm", "range_m_within_0.25_m"}}) {
      EXPECT_EQ(properties[name], std::get<double>(row[column(dumped)])) << name;
    }
    const auto flags = std::get<std::int64_t>(row[column("flags_within_0.25_m")]);
    EXPECT_EQ(properties["unmet_within_25_cm"], (flags & kUnmet) != 0);
    EXPECT_EQ(properties["reason_within_25_cm"], name_of(map.ranges.reason(sites, 1)));
    EXPECT_EQ(properties["extrapolated_within_25_cm"], (flags & kExtrapolated) != 0);
    const Eigen::Vector3d p_world_m =
        map.sites.sites[sites].p_map_m + map.sites.frame.origin_world_m;
    EXPECT_EQ(feature["geometry"]["coordinates"][0], p_world_m.x());
    ++sites;
  }
  EXPECT_NE(json["crs"]["properties"]["name"].get<std::string>().find("LOCAL_CS"),
            std::string::npos)
      << "metres are not degrees";
  EXPECT_EQ(sites, map.sites.sites.size());
  EXPECT_EQ(lines, 2u);
}

}  // namespace
}  // namespace sightline
