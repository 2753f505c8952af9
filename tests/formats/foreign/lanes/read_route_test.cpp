#include "formats/foreign/lanes/read_route.h"

#include <gtest/gtest.h>

#include <string>

#include "formats/base/random.h"
#include "formats/foreign/lanes/osm_text.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using enum ErrorCode;

// A straight lanelet along +x from (0, 0) to (10, 0), 4 m wide; its right way is written backwards.
constexpr std::string_view kLanelet = R"(<?xml version="1.0"?>
<osm version="0.6">
  <node id="1" lat="" lon=""><tag k="local_x" v="0"/><tag k="local_y" v="2"/><tag k="ele" v="5"/></node>
  <node id="2" lat="" lon=""><tag k="local_x" v="10"/><tag k="local_y" v="2"/><tag k="ele" v="5"/></node>
  <node id="3" lat="" lon=""><tag k="local_x" v="10"/><tag k="local_y" v="-2"/><tag k="ele" v="7"/></node>
  <node id="4" lat="" lon=""><tag k="local_x" v="0"/><tag k="local_y" v="-2"/><tag k="ele" v="7"/></node>
  <way id="11"><nd ref="1"/><nd ref="2"/></way>
  <way id="12"><nd ref="3"/><nd ref="4"/></way>
  <relation id="100">
    <member type="way" role="LEFT" ref="11"/><member type="way" role="RIGHT" ref="12"/>
    <tag k="type" v="lanelet"/><tag k="subtype" v="SUBTYPE"/><tag k="one_way" v="ONE_WAY"/>
  </relation>
</osm>
)";

std::string replaced(std::string text, const std::string& word, const std::string& by) {
  for (std::size_t at = text.find(word); at != std::string::npos;
       at = text.find(word, at + by.size())) {
    text.replace(at, word.size(), by);
  }
  return text;
}

std::string lanelet(const std::string& left = "left", const std::string& right = "right",
                    const std::string& subtype = "road", const std::string& one_way = "yes") {
  std::string text = replaced(std::string(kLanelet), "LEFT", left);
  text = replaced(text, "RIGHT", right);
  text = replaced(text, "SUBTYPE", subtype);
  return replaced(text, "ONE_WAY", one_way);
}

class ReadRoute : public testing::Test {
 protected:
  Result<Route> read(const std::string& name, std::string_view text,
                     const std::string& world = "local") {
    return read_route(folder_.write(name, text), *parse_world(world));
  }
  ErrorCode refusal(const std::string& name, std::string_view text,
                    const std::string& world = "local") {
    return failure_of(read(name, text, world), text).code;
  }
  ScratchFolder folder_;
};

TEST_F(ReadRoute, ALaneletIsFollowedBetweenItsSidesInItsDirection) {
  const Route route = value_of(read("lanes.osm", lanelet()));
  ASSERT_EQ(route.lines.size(), 1U);
  const RouteLine& line = route.lines[0];
  EXPECT_EQ(line.name, "lanelet 100");
  EXPECT_FALSE(line.is_both_ways);
  EXPECT_EQ(line.heights, RouteHeights::kRoad);
  EXPECT_EQ(line.points_world_m.front(), Eigen::Vector3d(0.0, 0.0, 6.0));
  EXPECT_EQ(line.points_world_m.back(), Eigen::Vector3d(10.0, 0.0, 6.0));
}

// A second lanelet between the same sides.
std::string two_lanelets(const std::string& attributes, const std::string& left_way) {
  const std::string first = lanelet();
  return replaced(
      first, "</osm>",
      "<relation id=\"200\" " + attributes + "><member type=\"way\" role=\"left\" ref=\"" +
          left_way + "\"/><member type=\"way\" role=\"right\" ref=\"12\"/>" +
          "<tag k=\"type\" v=\"lanelet\"/><tag k=\"subtype\" v=\"road\"/></relation></osm>");
}

TEST_F(ReadRoute, ABrokenLaneletCostsOneLaneletAndIsNamed) {
  EXPECT_EQ(value_of(read("both.osm", two_lanelets("", "11"))).lines.size(), 2U);
  const Route route = value_of(read("broken.osm", two_lanelets("", "99")));
  ASSERT_EQ(route.lines.size(), 1U);
  EXPECT_EQ(route.lines[0].name, "lanelet 100");
  ASSERT_EQ(route.warnings.size(), 1U);
  EXPECT_THAT(route.warnings[0], testing::HasSubstr("1 of 2 lanelets are broken and left out"));
  EXPECT_THAT(route.warnings[0], testing::HasSubstr("its left way is missing"));
}

TEST_F(ReadRoute, WhatJosmMarksAsDeletedIsNotThere) {
  const Route route = value_of(read("deleted.osm", two_lanelets("action=\"delete\"", "11")));
  EXPECT_EQ(route.lines.size(), 1U);
  EXPECT_TRUE(route.warnings.empty());
  const std::string without_way =
      replaced(lanelet(), "<way id=\"11\"", "<way action='delete' id=\"11\"");
  EXPECT_EQ(refusal("way.osm", without_way), kMalformedText);
}

TEST_F(ReadRoute, SidesThatAreSwappedTurnTheLaneRound) {
  const Route route = value_of(read("lanes.osm", lanelet("right", "left")));
  EXPECT_EQ(route.lines[0].points_world_m.front(), Eigen::Vector3d(10.0, 0.0, 6.0));
  EXPECT_EQ(route.lines[0].points_world_m.back(), Eigen::Vector3d(0.0, 0.0, 6.0));
}

TEST_F(ReadRoute, TheOrderOfASidesNodesDoesNotMatter) {
  const std::string forth = R"(<nd ref="1"/><nd ref="2"/>)";
  std::string text = lanelet();
  text.replace(text.find(forth), forth.size(), R"(<nd ref="2"/><nd ref="1"/>)");
  const Route route = value_of(read("lanes.osm", text));
  EXPECT_EQ(route.lines[0].points_world_m.front(), Eigen::Vector3d(0.0, 0.0, 6.0));
  EXPECT_EQ(route.lines[0].points_world_m.back(), Eigen::Vector3d(10.0, 0.0, 6.0));
}

TEST_F(ReadRoute, OnlyALaneThatIsNoOneWayStreetGoesBothWays) {
  EXPECT_TRUE(read("lanes.osm", lanelet("left", "right", "road", "no"))->lines[0].is_both_ways);
}

TEST_F(ReadRoute, WhereNoVehicleDrivesThereIsNoRoute) {
  EXPECT_EQ(refusal("lanes.osm", lanelet("left", "right", "crosswalk")), kMissingField);
}

TEST_F(ReadRoute, LatitudesAreNoPlaceInALocalWorld) {
  std::string text = lanelet();
  text = replaced(text, "local_", "other_");
  EXPECT_EQ(refusal("lanes.osm", text), kMissingField);
  text = replaced(text, "lat=\"\" lon=\"\"", "lat=\"48.98\" lon=\"8.39\"");
  const Result<Route> route = read("lanes.osm", text, "utm:32N");
  EXPECT_FALSE(route.has_value()) << "four nodes at one place are no lane";
  EXPECT_EQ(route.error().code, kMissingField);
}

TEST_F(ReadRoute, LatitudesAreLaidIntoTheWorldNamed) {
  const World world = *parse_world("utm:32N");
  const Route route = value_of(read("route.geojson", R"({"type": "FeatureCollection", "features": [
      {"type": "Feature", "geometry": {"type": "Point", "coordinates": [8.0, 48.0]}},
      {"type": "Feature", "geometry": {"type": "LineString",
        "coordinates": [[8.39, 48.98], [8.391, 48.98]]}}]})",
                                    "utm:32N"));
  ASSERT_EQ(route.lines.size(), 1U);
  EXPECT_EQ(route.lines[0].heights, RouteHeights::kNone);
  const Result<Geodetic> back = to_geodetic(world, route.lines[0].points_world_m[1]);
  EXPECT_NEAR(back->longitude_deg, 8.391, 1e-9);
  EXPECT_NEAR(back->latitude_deg, 48.98, 1e-9);
}

TEST_F(ReadRoute, GeoJsonInDegreesIsNoneOfALocalMap) {
  EXPECT_EQ(refusal("route.geojson",
                    R"({"type": "LineString", "coordinates": [[8.39, 48.98], [8.391, 48.98]]})"),
            kUnsupportedFormat);
}

TEST_F(ReadRoute, CsvLinesAreSetApartByAColumnOrAnEmptyLine) {
  const Route named = value_of(read("a.csv", "line,x,y\nA,0,0\nA,1,0\nB,5,5\nB,6,5\nB,7,5\n"));
  ASSERT_EQ(named.lines.size(), 2U);
  EXPECT_EQ(named.lines[1].points_world_m.size(), 3U);
  EXPECT_EQ(named.lines[1].heights, RouteHeights::kNone);
  const Route bare = value_of(read("b.csv", "0 0 2\n1 0 2\n\n5 5 2\n6 5 2\n"));
  ASSERT_EQ(bare.lines.size(), 2U);
  EXPECT_EQ(bare.lines[1].heights, RouteHeights::kRoad);
  EXPECT_EQ(bare.lines[1].points_world_m[0], Eigen::Vector3d(5.0, 5.0, 2.0));
}

TEST_F(ReadRoute, CsvInDegreesNeedsAWorldAndNamesIt) {
  const std::string named = "lat,lon\n48.98,8.390\n48.98,8.391\n";
  const Error local = failure_of(read("a.csv", named));
  EXPECT_EQ(local.code, kUnsupportedFormat);
  EXPECT_NE(local.message.find("route.world: utm:32N"), std::string::npos) << local.message;
  const Error bare = failure_of(read("b.csv", "8.390,48.98\n8.391,48.98\n"));
  EXPECT_EQ(bare.code, kUnsupportedFormat);
  EXPECT_NE(bare.message.find("lat,lon"), std::string::npos) << bare.message;
  const Route route = value_of(read("c.csv", named, "utm:32N"));
  const std::vector<Eigen::Vector3d>& points_m = route.lines.at(0).points_world_m;
  EXPECT_NEAR((points_m[1] - points_m[0]).norm(), 73.2, 0.3) << "a thousandth of a degree";
  EXPECT_NEAR(points_m[0].x(), 455'370.0, 50.0);
}

TEST_F(ReadRoute, ATrajectoryKeepsItsHeightsAndEndsWhereItJumps) {
  const Route route =
      value_of(read("poses.tum",
                    "0 0 0 1 0 0 0 1\n1 1 0 1 0 0 0 1\n2 1.05 0 1 0 0 0 1\n3 2 0 1 0 0 0 1\n"
                    "4 90 0 1 0 0 0 1\n5 91 0 1 0 0 0 1\n"));
  ASSERT_EQ(route.lines.size(), 2U);
  EXPECT_EQ(route.lines[0].points_world_m.size(), 3U) << "standing still is no route";
  EXPECT_EQ(route.lines[0].heights, RouteHeights::kVehicle);
}

TEST_F(ReadRoute, RefusesWhatHoldsNoLine) {
  EXPECT_EQ(refusal("route.dxf", "0\n"), kUnsupportedFormat);
  EXPECT_EQ(refusal("a.csv", "x,y\n1,two\n"), kMalformedText);
  EXPECT_EQ(refusal("b.csv", "x,y\n1,2,3\n"), kMalformedText);
  EXPECT_EQ(refusal("c.csv", "x,y\n1,2\n"), kMissingField);
  EXPECT_EQ(refusal("d.csv", "a,b\n1,2\n"), kMissingField);
  EXPECT_EQ(refusal("a.geojson", "{"), kMalformedText);
  EXPECT_EQ(refusal("b.geojson", R"({"type": "LineString", "coordinates": [[1], [2]]})"),
            kMalformedText);
  EXPECT_EQ(refusal("c.geojson", std::string(100'000, '[')), kMalformedText);
  EXPECT_EQ(refusal("a.osm", "<osm><node"), kMalformedText);
  EXPECT_EQ(refusal("b.osm", "<gpx/>"), kMalformedText);
  EXPECT_EQ(refusal("c.osm", replaced(lanelet(), "ref=\"12\"", "ref=\"13\"")), kMalformedText);
}

TEST_F(ReadRoute, RefusesWhatIsNowhereOnEarth) {
  const auto to = [](const char* x_m) {
    return replaced(lanelet(), "v=\"10\"", std::string("v=\"") + x_m + "\"");
  };
  EXPECT_EQ(refusal("a.osm", to("1e300")), kMalformedText);
  EXPECT_EQ(refusal("b.osm", to("200000")), kMalformedText);
  EXPECT_TRUE(read("c.osm", to("90000")).has_value());
  EXPECT_EQ(refusal("d.osm", replaced(lanelet(), "v=\"5\"", "v=\"1e9\"")), kMalformedText);
  EXPECT_EQ(refusal("a.csv", "0,0\n1e200,0\n"), kMalformedText);
  EXPECT_EQ(refusal("b.csv", "0,0\n5e7,0\n"), kMalformedText);
  EXPECT_EQ(refusal("a.geojson", R"({"type": "LineString", "coordinates": [[0,0],[1e200,0]]})"),
            kMalformedText);
}

TEST_F(ReadRoute, RefusesLaneletsOfMoreNodesThanAnyMapHas) {
  std::string nodes;
  for (int i = 0; i < 20'000; ++i) nodes += R"(<nd ref="1"/>)";
  std::string relations;
  for (int i = 0; i < 450; ++i) {
    relations += R"(<relation id="1"><member type="way" role="left" ref="11"/><member type="way" )"
                 R"(role="right" ref="12"/><tag k="type" v="lanelet"/></relation>)";
  }
  const std::string way = "<way id=\"11\">";
  std::string text = lanelet();
  text.insert(text.find(way) + way.size(), nodes);
  EXPECT_TRUE(read("one.osm", text).has_value());
  text.insert(text.find("</osm>"), relations);
  const Error error = failure_of(read("lanes.osm", text));
  EXPECT_EQ(error.code, kMalformedText);
  EXPECT_THAT(error.message, HasSubstr("nodes"));
}

TEST(Lanelets, DamagedOnesAreReadOrRefused) {
  const std::string whole = lanelet();
  const World world;
  Random random(1);
  std::size_t read_count = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(random.below(256));
    for (const std::string& text : {whole.substr(0, at), damaged}) {
      Route route;
      if (!parse_lanelets({text, "lanes.osm", world}, route)) continue;
      ++read_count;
      EXPECT_TRUE(validate(route).has_value()) << text;
    }
  }
  EXPECT_GT(read_count, 100U);
}

TEST(GeoJsonLines, DamagedOnesAreReadOrRefused) {
  const std::string whole =
      R"({"features": [{"geometry": {"type": "MultiLineString",
          "coordinates": [[[1, 2], [3, 4, 5]], [[6, 7, 1], [8e2, 9, 1]]]}}]})";
  const World world;
  Random random(2);
  for (int damage = 0; damage < 20'000; ++damage) {
    std::string text = whole;
    text[random.below(text.size())] = static_cast<char>(random.below(128));
    text[random.below(text.size())] = "[]{},:\"0"[random.below(9)];
    Route route;
    if (!parse_geojson({text, "route.geojson", world}, route) || route.lines.empty()) continue;
    EXPECT_TRUE(validate(route).has_value()) << text;
  }
}

TEST_F(ReadRoute, IsTheSameWhenReadBackFromBytes) {
  const Route route = value_of(read("lanes.osm", lanelet("left", "right", "road", "no")));
  const std::vector<std::byte> bytes = to_bytes(route);
  EXPECT_EQ(to_bytes(value_of(from_bytes<Route>(bytes))), bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(from_bytes<Route>(std::span(bytes).first(size)).has_value());
  }
}

// A line feed that is added behind a carriage return would make the document one of another manner.
TEST(OsmText, IsAddedToAsBeforeOnceAdditionsAreTakenOutAgain) {
  const std::string element = "<relation id=\"1\"><tag k=\"type\" v=\"lanelet\"/></relation>";
  OsmAdditions additions;
  additions.ways = {{"way id=\"-1\"", {"-2"}, {{"area", "yes"}}}};
  additions.of_relations = {{{"observation_range_010", "20"}}};
  for (const std::string before : {"", "\n", "\r\n", "\r", " \r", "\r ", "\r\r"}) {
    for (const std::string line_end : {"", "\n", "\r\n"}) {
      std::string text = "<osm>" + line_end + "<way id=\"11\"></way>";
      text += before + element + line_end + "</osm>" + line_end;
      const std::string added = value_of(with_additions(text, additions));
      const std::string without = value_of(without_additions(added, {"observation_range_"}));
      EXPECT_LT(without.size(), added.size());
      EXPECT_EQ(value_of(with_additions(without, additions)), added);
    }
  }
}

}  // namespace
}  // namespace sightline
