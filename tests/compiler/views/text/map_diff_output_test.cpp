#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "compiler/views/text/map_diff_json.h"
#include "compiler/views/text/map_diff_text.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/diff/diff_maps.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/changed_map.h"
#include "tests/support/json_schema.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

MapDiff diff_of(const CompiledMap& before, const CompiledMap& after) {
  return value_of(diff_maps(encode_map(before), encode_map(after), MapDiffOptions()));
}

// A street of 60 sites along x from (0, 0) of the map frame; at 20 to 39 m something changed.
CompiledMap street(bool is_changed) {
  CompiledMap map =
      random_map({.seed = 1, .site_count = 60, .nd_count = 0, .run_count = 1, .limits_m = {0.10}});
  for (std::size_t i = 0; i < 60; ++i) {
    const bool is_here = is_changed && i >= 20 && i < 40;
    map.sites.sites[i].p_map_m = {static_cast<double>(i), 0.0, 1.8};
    map.ranges.range_index[i] = is_here ? 2 : 0;
    map.ranges.flags[i] = is_here && i < 25 ? kUnmet : 0;
  }
  map.quality = quality_of(map.predicted, map.ranges, nullptr);
  return map;
}

std::string faults_of(const Json& document) {
  return schema_faults(
      Json::parse(*read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/diff.schema.json")),
      document);
}

TEST(MapDiffText, TellsTheStretchItsRangesAndWhatIsNewlyUnmet) {
  const std::string text = to_text(diff_of(street(false), street(true)));
  EXPECT_THAT(text, HasSubstr("No street changed; 20 of 60 sites have other answers."));
  EXPECT_THAT(text, HasSubstr("run 0, 20 - 39 m"));
  EXPECT_THAT(text, HasSubstr("10.0 -> 50.0 m, unmet +5"));
  EXPECT_THAT(
      text,
      HasSubstr("20 sites have a longer range, 0 a shorter one; 5 newly unmet, 0 no longer."));
}

TEST(MapDiffText, OfEqualMapsSaysSo) {
  const std::string text = to_text(diff_of(street(true), street(true)));
  EXPECT_THAT(text, HasSubstr("The maps are the same."));
  EXPECT_THAT(text, Not(HasSubstr("Stretches")));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(MapDiffText, IsOneScreenUnlessAllIsWanted) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const CompiledMap map = random_map({.seed = seed, .limits_m = {0.10, 0.25, 0.5}});
    const std::string text = summary_text(diff_of(map, changed_map(map, seed, false)));
    const std::vector<std::string> lines = lines_of(text);
    EXPECT_LE(lines.size(), 30U) << text;
    for (const std::string& line : lines) EXPECT_LE(line.size(), 120U) << line;
    EXPECT_THAT(text, HasSubstr("More: --all"));
  }
  const std::string text = summary_text(diff_of(street(false), street(true)));
  EXPECT_THAT(text, HasSubstr("run 0, 20 - 39 m"));
  EXPECT_THAT(text, HasSubstr("sites without a sufficient range for 0.1 m"));
}

TEST(MapDiffText, OfMapsFarFromEachOtherSaysThatTheyShareNoRoad) {
  CompiledMap elsewhere = street(true);
  for (Site& site : elsewhere.sites.sites) site.p_map_m.y() += 5000.0;
  const MapDiff diff = diff_of(street(false), elsewhere);
  const std::string first =
      "The maps share no road: none of the old map's 60 sites is near one of "
      "the new map's 60.";
  EXPECT_EQ(lines_of(summary_text(diff)).front(), first);
  EXPECT_EQ(lines_of(summary_text(diff)).size(), 3U) << summary_text(diff);
  EXPECT_EQ(lines_of(to_text(diff)).front(), first);
}

TEST(MapDiffText, CountsNewAndRemovedSitesApart) {
  CompiledMap moved = street(false);
  for (Site& site : moved.sites.sites) site.p_map_m.x() += 30.0;
  const MapDiff diff = diff_of(street(false), moved);
  EXPECT_THAT(summary_text(diff),
              HasSubstr(std::to_string(diff.sites_removed) + " of the old map's 60 are removed."));
  EXPECT_LT(diff.sites_removed, 60U);
  EXPECT_GT(diff.sites_removed, 0U);
}

TEST(MapDiffText, TellsTheLongestStretchesOnlyAndHowManyMoreThereAre) {
  CompiledMap before = random_map(
      {.seed = 2, .site_count = 900, .nd_count = 0, .run_count = 30, .limits_m = {0.10}});
  CompiledMap after = before;
  for (std::size_t i = 0; i < 900; ++i) {
    const std::size_t run = i / 30;
    before.sites.sites[i].p_map_m = after.sites.sites[i].p_map_m = {
        static_cast<double>(i % 30), 12.0 * static_cast<double>(run), 0.0};
    before.ranges.range_index[i] = before.ranges.flags[i] = after.ranges.flags[i] = 0;
    after.ranges.range_index[i] = i % 30 < i / 30 ? 1 : 0;  // run k has k changed sites
  }
  const MapDiff diff = diff_of(before, after);
  ASSERT_EQ(diff.stretches.size(), 29u);
  const std::string text = to_text(diff);
  EXPECT_THAT(text, HasSubstr("9 smaller changes are not listed"));
  EXPECT_THAT(text, HasSubstr("run 29, "));
  EXPECT_THAT(text, Not(HasSubstr("run 9, ")));
}

TEST(MapDiffMarkdown, IsATableWhoseTextCannotBreakIt) {
  CompiledMap after = street(true);
  after.version = "a | b <script>\nc";
  const std::string text = to_markdown(diff_of(street(false), after));
  EXPECT_THAT(text, HasSubstr("### Map diff: No street changed"));
  EXPECT_THAT(text, HasSubstr("|---|"));
  EXPECT_THAT(text, HasSubstr("a \\| b &lt;script>\\\\x0ac"));
}

TEST(MapDiffJson, FollowsItsSchemaOverRandomMaps) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const CompiledMap map = random_map({.seed = seed});
    const MapDiff diff = diff_of(map, changed_map(map, seed, seed % 2 == 0));
    const Json json = Json::parse(to_json(diff));
    EXPECT_EQ(faults_of(json), "");
    EXPECT_EQ(json["sites"].size(), diff.sites.size());
    EXPECT_EQ(json["stretches"].size(), diff.stretches.size());
  }
  Json broken = Json::parse(to_json(diff_of(street(false), street(true))));
  EXPECT_EQ(faults_of(broken), "");
  broken["stretches"][0].erase("begin_s_m");
  EXPECT_NE(faults_of(broken), "") << "the schema sees nothing";
}

TEST(MapDiffGeoJson, IsInLocalMetresAndSaysSoUnlessAZoneIsNamed) {
  CompiledMap before = street(false);
  CompiledMap after = street(true);
  for (CompiledMap* map : {&before, &after}) {
    map->ndt.frame.origin_world_m = {448000.0, 5411968.0, 0.0};  // multiples of 64 m
    map->sites.frame = map->ndt.frame;
  }
  const MapDiff diff = diff_of(before, after);
  const Json local = Json::parse(*to_geojson(diff, World{}));
  EXPECT_THAT(local["coordinate_frame"].get<std::string>(), HasSubstr("not longitude"));
  ASSERT_EQ(local["features"].size(), 21u);
  EXPECT_EQ(local["features"][0]["geometry"]["type"], "LineString");
  EXPECT_EQ(local["features"][0]["properties"]["kind"], "stretch");
  EXPECT_EQ(local["features"][0]["geometry"]["coordinates"][0][0], 448020.0);
  // The Eiffel Tower is at 2.2945 E, 48.8584 N, a few hundred metres from there.
  const Json earth = Json::parse(*to_geojson(diff, *parse_world("utm:31N")));
  EXPECT_NEAR(earth["features"][0]["geometry"]["coordinates"][0][0].get<double>(), 2.29, 0.01);
  EXPECT_NEAR(earth["features"][0]["geometry"]["coordinates"][0][1].get<double>(), 48.858, 0.01);
  EXPECT_EQ(earth["features"][0]["geometry"]["coordinates"][0][2],
            local["features"][0]["geometry"]["coordinates"][0][2]);
}

TEST(MapDiffGeoJson, RefusesAPlaceThatIsNotOfTheZone) {
  CompiledMap before = street(false);
  CompiledMap after = street(true);
  for (CompiledMap* map : {&before, &after}) {
    map->ndt.frame.origin_world_m = {64.0e5, 0.0, 0.0};  // 6400 km east of the zone's middle
    map->sites.frame = map->ndt.frame;
  }
  EXPECT_EQ(code_of(to_geojson(diff_of(before, after), *parse_world("utm:31N"))),
            ErrorCode::kBadArgument);
}

}  // namespace
}  // namespace sightline
