#include "compiler/views/picture/ranges_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compiler/views/picture/raster.h"
#include "tests/support/toy_world.h"

namespace sightline {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

Sites straight_route(std::size_t count) {
  Sites sites;
  sites.sites.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    sites.sites[i].p_map_m = {static_cast<double>(i), 0.0, 2.0};
  }
  return sites;
}

// Two limits; the looser one always looks 10 m far.
RangeTable ranges_of(const std::vector<std::uint8_t>& tight) {
  RangeTable ranges;
  ranges.looks = every_return_at({10.0, 30.0, 50.0});
  ranges.promises.resize(2);
  ranges.promises[0].limit_m = 0.1;
  ranges.promises[1].limit_m = 0.25;
  ranges.site_count = static_cast<std::uint32_t>(tight.size());
  for (const std::uint8_t range : tight) {
    ranges.range_index.insert(ranges.range_index.end(), {range, 0});
    ranges.flags.insert(ranges.flags.end(), {0, 0});
    ranges.reasons.insert(ranges.reasons.end(), {Reason::kModel, Reason::kModel});
  }
  return ranges;
}

Nd axis_nd(const Eigen::Vector3d& mean_m, const Eigen::Vector3d& sigma_m) {
  Nd nd;
  nd.key = cell_key(mean_m, 2.0);
  nd.point_count = 100;
  nd.mean_m = mean_m;
  nd.covariance_m2 = sigma_m.cwiseAbs2().asDiagonal();
  decompose(nd);
  return nd;
}

NdtMap wall_ground_and_pole() {
  NdtMap map;
  map.nds = {axis_nd({3.0, 1.0, 0.0}, {0.5, 0.5, 0.01}), axis_nd({3.0, 5.0, 2.0}, {0.5, 0.02, 0.5}),
             axis_nd({9.0, 3.0, 1.0}, {0.05, 0.05, 0.6})};
  return map;
}

std::string colour_of(std::size_t range) { return colour_name(range_colour_on_paper(range, 3)); }
constexpr MapBox kNdBox{0.0, 0.0, 12.0, 6.0};
constexpr MapBox kBox{-10.0, -10.0, 20.0, 10.0};

TEST(NdtPicture, ColoursEllipsesByClassAndPutsThemInPlace) {
  const Raster raster = ndt_picture(wall_ground_and_pole(), {}, kNdBox);
  ASSERT_EQ(raster.width, 1200U);
  ASSERT_EQ(raster.height, 600U);
  const Colour paper = raster.at(1199, 0);
  const Colour ground = raster.at(300, 500);  // (3, 1) m
  const Colour wall = raster.at(300, 100);    // (3, 5) m
  const Colour pole = raster.at(900, 300);    // (9, 3) m
  EXPECT_EQ(paper, (Colour{255, 255, 255}));
  for (const Colour& one : {ground, wall, pole}) EXPECT_NE(one, paper);
  EXPECT_NE(ground, wall);
  EXPECT_NE(wall, pole);
  // Two standard deviations: a metre along the wall, 5 cm across.
  EXPECT_EQ(raster.at(395, 100), wall);
  EXPECT_EQ(raster.at(405, 100), paper);
  EXPECT_EQ(raster.at(300, 107), paper);
}

TEST(NdtPicture, DrawsTheSameEllipsesAsText) {
  Sites sites;
  sites.sites.resize(2);
  sites.sites[0].p_map_m = {6.0, 3.0, 1.0};
  sites.sites[1].p_map_m = {60.0, 3.0, 1.0};  // outside
  const std::string svg = ndt_picture_svg(wall_ground_and_pole(), sites, kNdBox);
  EXPECT_THAT(svg, StartsWith("<svg "));
  EXPECT_THAT(svg, EndsWith("</svg>\n"));
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0.000 -6.000 12.000 6.000\""));
  EXPECT_THAT(svg, HasSubstr("translate(3.000 -5.000)"));
  EXPECT_THAT(svg, HasSubstr("rx=\"1.000\" ry=\"0.050\""));
  EXPECT_EQ(count_of(svg, "<circle"), 1U);
}

TEST(NdtPicture, LeavesOutWhatLiesOutsideTheBox) {
  const NdtMap map = random_ndt_map(1, 500, 60.0);
  const MapBox all = box_around(map);
  const MapBox half{all.low_x_m, all.low_y_m, 0.0, all.high_y_m};
  const auto ellipses = [&](const MapBox& box) {
    return count_of(ndt_picture_svg(map, {}, box), "<ellipse");
  };
  EXPECT_EQ(ellipses(all), map.nds.size());
  std::size_t expected = 0;
  for (const Nd& nd : map.nds) expected += nd.mean_m.x() <= 0.0 ? 1 : 0;
  EXPECT_EQ(ellipses(half), expected);
}

TEST(RangesPicture, ColoursEachStretchOfTheRouteByItsRangeForTheTightestLimit) {
  const std::string svg =
      ranges_picture_svg({}, straight_route(6), ranges_of({0, 0, 0, 2, 2, 2}), kBox);
  EXPECT_THAT(svg, StartsWith("<svg xmlns="));
  EXPECT_THAT(svg, EndsWith("</svg>\n"));
  EXPECT_THAT(svg, HasSubstr("M0.00 -0.00L1.00 -0.00L2.00 -0.00h.01"));
  EXPECT_THAT(svg, HasSubstr("M2.00 -0.00L3.00 -0.00L4.00 -0.00L5.00 -0.00h.01"));
  EXPECT_EQ(count_of(svg, "stroke:" + colour_of(0)), 1U);
  EXPECT_EQ(count_of(svg, "stroke:" + colour_of(1)), 0U);
  EXPECT_EQ(count_of(svg, "stroke:" + colour_of(2)), 1U);
  EXPECT_THAT(svg, HasSubstr("Observation range (m) for a localization error within 10 cm"));
  for (const char* range : {">10<", ">30<", ">50<"}) EXPECT_THAT(svg, HasSubstr(range));
}

TEST(RangesPicture, SpreadsItsColoursOverTheRangesThatAreTaken) {
  const std::string svg = ranges_picture_svg({}, straight_route(3), ranges_of({1, 1, 2}), kBox);
  EXPECT_EQ(count_of(svg, "stroke:" + colour_name(range_colour_on_paper(0, 2))), 1U);
  EXPECT_EQ(count_of(svg, "stroke:" + colour_name(range_colour_on_paper(1, 2))), 1U);
  EXPECT_THAT(svg, Not(HasSubstr(">10<")));
  for (const char* range : {">30<", ">50<"}) EXPECT_THAT(svg, HasSubstr(range));
}

TEST(RangesPicture, DrawsNothingBetweenTwoRuns) {
  Sites sites = straight_route(4);
  sites.sites[2].run = sites.sites[3].run = 1;
  const std::string svg = ranges_picture_svg({}, sites, ranges_of({1, 1, 1, 1}), kBox);
  EXPECT_THAT(svg, HasSubstr("\"M0.00 -0.00L1.00 -0.00h.01"));
  EXPECT_THAT(svg, HasSubstr("\"M2.00 -0.00L3.00 -0.00h.01"));
}

TEST(RangesPicture, MarksWhereNoRangeIsGoodEnoughAndSaysSo) {
  RangeTable ranges = ranges_of({2, 2, 2});
  const std::string good = ranges_picture_svg({}, straight_route(3), ranges, kBox);
  EXPECT_EQ(count_of(good, "<circle"), 0U);
  EXPECT_THAT(good, Not(HasSubstr("no range is good enough")));
  ranges.flags = {0, 0, kUnmet, 0, 0, kUnmet};  // the last one of the looser limit
  const std::string unmet = ranges_picture_svg({}, straight_route(3), ranges, kBox);
  EXPECT_EQ(count_of(unmet, "<circle"), 2U) << "the site and the legend";
  EXPECT_THAT(unmet, HasSubstr("no range is good enough"));
}

TEST(RangesPicture, ShowsStandingNdsInsideTheBoxAlone) {
  NdtMap map;
  map.nds = {axis_nd({3.0, 5.0, 2.0}, {0.5, 0.02, 0.5}),    // a wall along x
             axis_nd({3.0, 1.0, 0.0}, {0.5, 0.5, 0.01}),    // ground
             axis_nd({90.0, 5.0, 2.0}, {0.5, 0.02, 0.5})};  // a wall far off
  const std::string svg = ranges_picture_svg(map, straight_route(3), ranges_of({0, 0, 0}), kBox);
  const bool to_the_right = svg.find("d=\"M2.0 -5.0l2.0 ") != std::string::npos;
  const bool to_the_left = svg.find("d=\"M4.0 -5.0l-2.0 ") != std::string::npos;
  EXPECT_TRUE(to_the_right || to_the_left) << svg;
  EXPECT_EQ(count_of(svg, "l2.0 ") + count_of(svg, "l-2.0 "), 1U);
}

TEST(RangesPicture, ShowsOneNdOfEachColumnOfCells) {
  NdtMap map;
  map.nds = {axis_nd({3.0, 5.0, 1.0}, {0.5, 0.02, 0.5}),
             axis_nd({3.0, 5.0, 3.0}, {0.3, 0.02, 0.5})};
  map.nds[1].point_count = 200;
  const std::string svg = ranges_picture_svg(map, straight_route(3), ranges_of({0, 0, 0}), kBox);
  EXPECT_EQ(count_of(svg, "l2.0 ") + count_of(svg, "l-2.0 "), 0U);
  EXPECT_EQ(count_of(svg, "l1.2 ") + count_of(svg, "l-1.2 "), 1U) << "that of more points";
}

TEST(RangesPicture, IsFortyMetresWiderThanTheRoute) {
  const MapBox box = ranges_picture_box(straight_route(11));
  EXPECT_EQ(box.low_x_m, -40.0);
  EXPECT_EQ(box.high_x_m, 50.0);
  EXPECT_EQ(box.low_y_m, -40.0);
  EXPECT_EQ(box.high_y_m, 40.0);
  EXPECT_EQ(ranges_picture_box({}).high_x_m, 0.0);
}

}  // namespace
}  // namespace sightline
