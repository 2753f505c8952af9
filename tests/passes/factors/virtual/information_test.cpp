#include "passes/factors/virtual/information.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

// Flat NDs facing +x at x = 5 and +y at y = 15 as seen from the origin, of sigmas 0.5, 0.5, 0.
NdtMap two_walls() {
  NdtMap map;
  for (const int axis : {0, 1}) {
    Nd nd;
    nd.point_count = 10;
    nd.mean_m = Eigen::Vector3d(1.0, 1.0, 1.0);
    nd.mean_m[axis] = axis == 0 ? 5.0 : 15.0;
    nd.key = cell_key(nd.mean_m, 2.0);
    Eigen::Vector3d variance_m2 = Eigen::Vector3d::Constant(0.25);
    variance_m2[axis] = 0.0;
    nd.covariance_m2 = variance_m2.asDiagonal();
    decompose(nd);
    map.nds.push_back(nd);
  }
  std::swap(map.nds[0], map.nds[1]);  // by key
  return map;
}

std::vector<ScanInformation> look(const std::vector<Eigen::Vector3d>& points_m) {
  const NdtMap map = two_walls();
  EXPECT_TRUE(validate(map).has_value());
  return scan_information(Eigen::Vector3d::Zero(), points_m, map, make_match_grid(map),
                          {10.0, 20.0});
}

TEST(ScanInformation, AddsUpSamplesWithinEachRangeByHand) {
  const std::vector<ScanInformation> found =
      look({{1.0, 15.0, 1.0}, {5.0, 1.0, 1.0}, {8.0, 0.0, 0.0}});
  // Regularised variances: 0.25 along the wall, 0.0025 across.
  EXPECT_NEAR(found[0].pose(0, 0), 400.0, 1e-9);
  EXPECT_NEAR(found[0].pose(1, 1), 4.0, 1e-9);
  EXPECT_NEAR(found[1].pose(0, 0), 404.0, 1e-9);
  EXPECT_NEAR(found[1].pose(1, 1), 404.0, 1e-9);
  // Yaw moves the first wall's sample by (-1, 5): 1 m across, 5 m along.
  EXPECT_NEAR(found[0].pose(5, 5), 400.0 * 1.0 + 4.0 * 25.0, 1e-9);
  EXPECT_NEAR(found[0].pose(0, 5), 400.0 * -1.0, 1e-9);
  EXPECT_EQ(found[0].pose, found[0].pose.transpose());
}

TEST(ScanInformation, CountsSamplesInNoValidNdAndAddsNothingForThem) {
  const std::vector<ScanInformation> found = look({{5.0, 1.0, 1.0}, {-6.0, 0.0, 0.0}});
  EXPECT_EQ(found[0].point_count, 2U);
  EXPECT_EQ(found[0].unmatched_count, 1U);
  EXPECT_EQ(found[1].point_count, 2U);
  EXPECT_EQ(found[0].pose, look({{5.0, 1.0, 1.0}})[0].pose);
}

TEST(ScanInformation, SumsTheHorizontalPartOfPlanarNormals) {
  const std::vector<ScanInformation> found = look({{5.0, 1.0, 1.0}, {1.0, 15.0, 1.0}});
  EXPECT_NEAR(found[0].planar_normals(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(found[0].planar_normals(1, 1), 0.0, 1e-12);
  EXPECT_NEAR(found[1].planar_normals(1, 1), 1.0, 1e-12);
}

TEST(ScanInformation, TakesASampleAtExactlyTheRange) {
  EXPECT_EQ(look({{0.0, -10.0, 0.0}})[0].point_count, 1U);
  EXPECT_EQ(look({{0.0, -10.0000001, 0.0}})[0].point_count, 0U);
}

}  // namespace
}  // namespace sightline
