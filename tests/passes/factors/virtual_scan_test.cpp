#include "passes/factors/virtual_scan.h"

#include <gtest/gtest.h>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "formats/base/random.h"
#include "formats/symmetric_eigen.h"
#include "passes/matching/match_starts.h"
#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

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

Matrix6d random_information(Random& random) {
  Matrix6d root;
  for (int i = 0; i < 36; ++i) root(i % 6, i / 6) = 10.0 * random.normal();
  return root * root.transpose();
}

TEST(Crlb, OfNothingIsThePrior) {
  const Crlb bound = crlb(Matrix6d::Zero());
  EXPECT_NEAR(bound.max_m, 10.0, 1e-12);
  EXPECT_NEAR(bound.min_m, 10.0, 1e-12);
  EXPECT_NEAR(bound.yaw_rad, 10.0 * std::numbers::pi / 180.0, 1e-12);
}

TEST(Crlb, SaysWhichWayTheStreetRuns) {
  // Walls on both sides of a street at 30 degrees: position across is known to a millimetre.
  const double street_rad = 30.0 * std::numbers::pi / 180.0;
  const Eigen::Vector2d across(-std::sin(street_rad), std::cos(street_rad));
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<2, 2>() = 1e6 * across * across.transpose();
  const Crlb bound = crlb(information);
  EXPECT_NEAR(bound.heading_deg, 30.0, 1e-6);
  EXPECT_NEAR(bound.max_m, 10.0, 1e-6);
  EXPECT_NEAR(bound.min_m, 1e-3, 1e-9);
}

TEST(Crlb, GrowsWhereYawMustBeEstimatedFromTheSameSamples) {
  // x + 5 yaw is known well, yaw alone hardly: then x is not known well.
  Matrix6d information = Matrix6d::Zero();
  Eigen::Matrix<double, 6, 1> row = Eigen::Matrix<double, 6, 1>::Zero();
  row[0] = 1.0;
  row[5] = 5.0;
  information = 1e6 * row * row.transpose();
  information(1, 1) = 1e6;
  const double yaw_alone_rad = 10.0 * std::numbers::pi / 180.0;
  const double expected_m =
      5.0 * yaw_alone_rad / std::sqrt(1.0 + 0.25 * std::pow(yaw_alone_rad, 2));
  EXPECT_NEAR(crlb(information).max_m, expected_m, 1e-5);
}

TEST(Crlb, FollowsARotationOfTheWorldAboutTheVertical) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Matrix6d information = random_information(random);
    const double turn_rad = random.uniform(-3.0, 3.0);
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Matrix6d both = Matrix6d::Zero();
    both.topLeftCorner<3, 3>() = rotation;
    both.bottomRightCorner<3, 3>() = rotation;
    const Crlb before = crlb(information);
    const Crlb after = crlb(both * information * both.transpose());
    EXPECT_NEAR(after.max_m, before.max_m, 1e-9 * before.max_m);
    EXPECT_NEAR(after.yaw_rad, before.yaw_rad, 1e-9 * before.yaw_rad);
    const double turned_deg =
        after.heading_deg - before.heading_deg - turn_rad * 180.0 / std::numbers::pi;
    EXPECT_NEAR(std::remainder(turned_deg, 180.0), 0.0, 1e-5);
  }
}

TEST(HzLmin, IsZeroBetweenParallelWallsAndGrowsWithTheFirstCrossWall) {
  const Eigen::Vector2d across(0.0, 1.0);
  const Eigen::Matrix2d walls = 50.0 * across * across.transpose();
  EXPECT_EQ(hz_lmin(walls), 0.0);
  EXPECT_EQ(hz_lmin(walls + 3.0 * Eigen::Vector2d::UnitX() * Eigen::Vector2d::UnitX().transpose()),
            3.0);
}

TEST(HzLmin, IsTheSmallerEigenvalue) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    Eigen::Matrix2d root;
    root << random.normal(), random.normal(), random.normal(), random.normal();
    const Eigen::Matrix2d matrix = root * root.transpose();
    EXPECT_NEAR(hz_lmin(matrix), symmetric_eigen<2>(matrix).values[0], 1e-12 * matrix.norm());
  }
}

VirtualPlace place_at_origin(std::span<const Eigen::Vector3d> points_m) {
  return {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), points_m, 0.0};
}

double mean_start_m() {
  double sum_m = 0.0;
  for (const InitialOffset& offset : initial_offsets(StartPattern{})) {
    sum_m += std::hypot(offset.x_m, offset.y_m, offset.z_m) / 12.0;
  }
  return sum_m;
}

std::vector<Eigen::Vector3d> street_points(std::uint64_t seed, double reach_m, bool has_windows) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < static_cast<int>(4000 * reach_m); ++i) {
    const double x_m = random.uniform(-reach_m, reach_m);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const double wall_m = has_windows && x_m - 1.5 * std::floor(x_m / 1.5) < 0.6 ? 3.6 : 3.0;
    const Eigen::Vector3d noise_m = 0.02 * random_vector(random, -1.0, 1.0);
    const bool is_ground = i % 5 == 0;
    points_m.push_back(
        noise_m + (is_ground ? Eigen::Vector3d(x_m, random.uniform(-3.0, 3.0), -1.7)
                             : Eigen::Vector3d(x_m, side * wall_m, random.uniform(-1.7, 3.0))));
  }
  return points_m;
}

TEST(VirtualMatch, OfNothingEndsWhereItBeganAndHasARivalEverywhere) {
  const Localizer localizer = make_localizer(room_map(), localizer_named("searching"));
  const VirtualMatch match = virtual_match(localizer, place_at_origin({}));
  EXPECT_NEAR(match.error_m, mean_start_m(), 1e-12);
  EXPECT_EQ(match.rival_score, 1.0);
}

TEST(VirtualMatch, InARoomEndsWithinCentimetresAndHasNoRival) {
  const Localizer localizer = make_localizer(room_map(), localizer_named("searching"));
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 8000, 0.02), 1.0);
  const VirtualMatch match = virtual_match(localizer, place_at_origin(points_m));
  EXPECT_LT(match.error_m, 0.06);
  EXPECT_LT(match.rival_score, 0.8);
}

TEST(VirtualMatch, InAStreetOfEqualWindowsFindsTheRivalThatTheVehicleMayEndIn) {
  const NdtMap map = simple_map(street_points(1, 30.0, true), 1.0);
  const Localizer localizer = make_localizer(map, localizer_named("searching"));
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(street_points(2, 12.0, true), 0.5);
  VirtualPlace place = place_at_origin(points_m);
  const VirtualMatch along = virtual_match(localizer, place);
  EXPECT_GT(along.error_m, 0.25);
  EXPECT_GT(along.rival_score, 0.95);
  place.loose_heading_deg = 90.0;
  EXPECT_LT(virtual_match(localizer, place).rival_score, 0.8) << "no wall is taken for the other";
}

TEST(VirtualMatch, LaysStartsOutAlongTheVehicle) {
  const Localizer localizer = make_localizer(room_map(), localizer_named("searching"));
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 8000, 0.02), 1.0);
  VirtualPlace place = place_at_origin(points_m);
  const double ahead_m = virtual_match(localizer, place).error_m;
  place.R_map_vehicle = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const double turned_m = virtual_match(localizer, place).error_m;
  EXPECT_NE(ahead_m, turned_m);
  EXPECT_NEAR(ahead_m, turned_m, 0.05);
}

}  // namespace
}  // namespace sightline
