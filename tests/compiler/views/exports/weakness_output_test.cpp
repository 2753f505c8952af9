#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "compiler/views/exports/weakness_json.h"
#include "compiler/views/text/weakness_text.h"
#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

Sites street() {
  Sites sites;
  sites.frame.origin_world_m = {448000.0, 5411008.0, 0.0};
  for (int i = 0; i < 5; ++i) {
    Site site;
    site.s_m = i;
    site.p_map_m = {10.0, static_cast<double>(i), 1.8};
    sites.sites.push_back(site);
  }
  return sites;
}

Weakness weakness() {
  ExplainedStretch one;
  one.stretch.first_site = 1;
  one.stretch.last_site = 3;
  one.stretch.from_m = 1.0;
  one.stretch.to_m = 3.0;
  one.stretch.worst_site = 2;
  one.stretch.worst = {every_return(50.0), 0.07, 0.75, 0.3, false};
  one.loose = {5.0, 5.0, 0.02, 0.005, 0.001, true};
  one.sights = {132, 4, 31.0, 0.9};
  one.rival_score = 0.91;
  one.kind = PlaceKind::kAvenue;
  one.cause = WeakCause::kRepeated;
  TargetAdvice advice;
  advice.target.foot_map_m = {14.0, 2.0, 0.1};
  advice.target.facing = {0.0, 1.0};
  advice.beside_m = -4.0;
  advice.nearest_site = 2;
  advice.return_count = 80;
  advice.std_before_m = 0.02;
  advice.std_after_m = 0.015;
  advice.gain = 0.25;
  advice.gain_at_worst = 0.3;
  one.advice = {advice};
  Weakness found;
  found.limit_m = 0.1;
  found.route_m = 5.0;
  found.weak_m = 3.0;
  found.stretch_count = 2;
  found.stretches = {one, one};
  found.stretches[1].stretch.first_site = found.stretches[1].stretch.last_site = 2;
  found.stretches[1].advice.clear();
  found.stretches[1].rival_score.reset();
  found.stretches[1].sights.nearest_holding_m.reset();
  found.stretches[1].cause = WeakCause::kDistant;
  return found;
}

TEST(WeaknessOutput, InJsonKeepsToItsSchemaAndLiesInTheWorld) {
  const Json schema =
      Json::parse(*read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/weak.schema.json"));
  const Json json = Json::parse(to_json(weakness(), street()));
  EXPECT_EQ(schema_faults(schema, json), "");
  EXPECT_EQ(json["stretches"][0]["worst_world_m"], Json({448010.0, 5411010.0, 1.8}));
  EXPECT_EQ(json["stretches"][0]["advice"][0]["foot_world_m"], Json({448014.0, 5411010.0, 0.1}));
  EXPECT_EQ(json["stretches"][0]["advice"][0]["facing_deg"], 90.0);
  EXPECT_EQ(json["stretches"][0]["cause"], "repeated");
  EXPECT_EQ(json["stretches"][0]["place_kind"], "avenue");
  Json broken = json;
  broken["stretches"][0]["cause"] = "fog";
  EXPECT_NE(schema_faults(schema, broken), "");
}

TEST(WeaknessOutput, InGeoJsonIsLinesAndPointsWhereTheWorldSays) {
  const std::string text = value_of(to_geojson(weakness(), street(), *parse_world("utm:32N")));
  const Json json = Json::parse(text);
  ASSERT_EQ(json["features"].size(), 3U);
  EXPECT_EQ(json["features"][0]["geometry"]["type"], "LineString");
  EXPECT_EQ(json["features"][0]["geometry"]["coordinates"].size(), 3U);
  EXPECT_EQ(json["features"][1]["properties"]["kind"], "advice");
  EXPECT_EQ(json["features"][1]["properties"]["stretch"], 1);
  EXPECT_EQ(json["features"][2]["geometry"]["type"], "Point");  // one site is no line
  const Json& place = json["features"][1]["geometry"]["coordinates"];
  EXPECT_NEAR(place[0].get<double>(), 8.29, 0.01);  // 52 km west of the zone's middle, 9 degrees
  EXPECT_NEAR(place[1].get<double>(), 48.85, 0.01);
  EXPECT_FALSE(json.contains("crs"));
  const Json local = Json::parse(*to_geojson(weakness(), street(), World()));
  EXPECT_TRUE(local.contains("crs"));
  EXPECT_EQ(local["features"][1]["geometry"]["coordinates"][0], 448014.0);
}

TEST(WeaknessOutput, OfPlacesThatAreNoneOfTheWorldIsRefused) {
  Sites far = street();
  far.frame.origin_world_m.x() = 9e7;
  EXPECT_EQ(code_of(to_geojson(weakness(), far, *parse_world("utm:32N"))), ErrorCode::kBadArgument);
}

TEST(WeaknessOutput, ForPeopleSaysWhereWhyAndWhatWouldHelp) {
  const std::string text = to_text(weakness(), street());
  EXPECT_THAT(text, HasSubstr("2 weak stretches, 3 of 5 m of route"));
  EXPECT_THAT(text, HasSubstr("4 of 132 upright surfaces seen within 50 m hold it along the road"));
  EXPECT_THAT(text, HasSubstr("the nearest 31 m away; half a metre or"));
  EXPECT_THAT(text, HasSubstr("left%: share of the limit that this"));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120U) << line;
  EXPECT_THAT(text, HasSubstr("25.0 % less: at (448014.0, 5411010.0)"));
  EXPECT_THAT(text, HasSubstr("4.0 m right of site 2"));
  EXPECT_THAT(text, HasSubstr("no place found for a board"));
}

TEST(WeaknessOutput, AsATableHasARowForEachStretch) {
  const Table table = table_of(weakness(), street());
  ASSERT_EQ(table.rows.size(), 2U);
  for (const std::vector<Cell>& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
  const std::string csv = format_table(table, TableFormat::kCsv);
  EXPECT_THAT(csv, HasSubstr("# positions_are: world coordinates, m"));
  EXPECT_THAT(csv, HasSubstr("50 m,avenue,repeated,5"));
}

}  // namespace
}  // namespace sightline
