#include "compiler/views/picture/ndt_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/toy_world.h"

namespace sightline {
namespace {

// An ND of the given spreads along the map's axes.
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

constexpr MapBox kBox{0.0, 0.0, 12.0, 6.0};

TEST(NdtPicture, ColoursEllipsesByClassAndPutsThemInPlace) {
  const Raster raster = ndt_picture(wall_ground_and_pole(), {}, kBox);
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
  const std::string svg = ndt_picture_svg(wall_ground_and_pole(), sites, kBox);
  EXPECT_THAT(svg, testing::StartsWith("<svg "));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
  EXPECT_THAT(svg, testing::HasSubstr("viewBox=\"0.000 -6.000 12.000 6.000\""));
  EXPECT_THAT(svg, testing::HasSubstr("translate(3.000 -5.000)"));
  EXPECT_THAT(svg, testing::HasSubstr("rx=\"1.000\" ry=\"0.050\""));
  std::size_t circles = 0;
  for (std::size_t at = svg.find("<circle"); at != std::string::npos;
       at = svg.find("<circle", at + 1)) {
    ++circles;
  }
  EXPECT_EQ(circles, 1U);
}

TEST(NdtPicture, LeavesOutWhatLiesOutsideTheBox) {
  const NdtMap map = random_ndt_map(1, 500, 60.0);
  const MapBox all = box_around(map);
  const MapBox half{all.low_x_m, all.low_y_m, 0.0, all.high_y_m};
  const auto ellipses = [&](const MapBox& box) {
    const std::string svg = ndt_picture_svg(map, {}, box);
    std::size_t count = 0;
    for (std::size_t at = svg.find("<ellipse"); at != std::string::npos;
         at = svg.find("<ellipse", at + 1)) {
      ++count;
    }
    return count;
  };
  EXPECT_EQ(ellipses(all), map.nds.size());
  std::size_t expected = 0;
  for (const Nd& nd : map.nds) expected += nd.mean_m.x() <= 0.0 ? 1 : 0;
  EXPECT_EQ(ellipses(half), expected);
}

}  // namespace
}  // namespace sightline
