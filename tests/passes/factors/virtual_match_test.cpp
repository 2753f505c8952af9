#include "passes/factors/virtual_match.h"

#include <gtest/gtest.h>

#include <cmath>

#include "passes/matching/match_starts.h"
#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

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

// A street along x between two walls, which are smooth or have a window at every metre and a half.
std::vector<Eigen::Vector3d> street_points(std::uint64_t seed, double reach_m, bool has_windows) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < static_cast<int>(4000 * reach_m); ++i) {
    const double x_m = random.uniform(-reach_m, reach_m);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const double phase_m = x_m - 1.5 * std::floor(x_m / 1.5);
    const double wall_m = has_windows && phase_m < 0.6 ? 3.6 : 3.0;
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
