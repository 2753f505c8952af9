#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "examples/town/drive/drive.h"
#include "passes/map/build_ndt.h"
#include "passes/map/choose_sites.h"
#include "passes/trajectory/align_drive.h"
#include "passes/trajectory/estimate_given.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "tests/passes/trajectory/sweep/uneven_town.h"
#include "tests/support/test_context.h"

// Drives through a generated town whose poses are thrown away, against the truth. Longer ones are
// measured by tests/bench/trajectory_bench.

namespace sightline {
namespace {

std::vector<Pose> poses_of(const Trajectory& trajectory) {
  std::vector<Pose> poses;
  for (const TrajectoryPose& pose : trajectory.poses) poses.push_back(pose.T_map_vehicle);
  return poses;
}

// Root mean square distance, after the best rigid fit where `fits`.
double rmse_m(const std::vector<Pose>& found, const std::vector<Pose>& truth, bool fits) {
  const auto count = static_cast<Eigen::Index>(truth.size());
  Eigen::Matrix3Xd a(3, count);
  Eigen::Matrix3Xd b(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    a.col(i) = found[static_cast<std::size_t>(i)].translation();
    b.col(i) = truth[static_cast<std::size_t>(i)].translation();
  }
  Pose T_truth_found = Pose::Identity();
  if (fits) T_truth_found.matrix() = Eigen::umeyama(a, b, false);
  double sum_m2 = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    sum_m2 += (T_truth_found * Eigen::Vector3d(a.col(i)) - b.col(i)).squaredNorm();
  }
  return std::sqrt(sum_m2 / static_cast<double>(count));
}

town::DriveSimulator drive_through(const town::Town& town, std::uint64_t number, double length_m) {
  town::DriveOptions options = town::usual_drive(town.options, number, *town::town_sensor(16));
  options.length_m = length_m;
  return *town::DriveSimulator::make(town, options);
}

Drive without_poses(const town::DriveSimulator& simulator) {
  Drive drive = town::recorded(simulator, "town", simulator.T_town_vehicle(), 2);
  for (ScanInfo& scan : drive.scans) scan.T_world_vehicle.reset();
  return drive;
}

TEST(EstimateTrajectoryInATown, GoesRoundABlockWithoutPoses) {
  const town::Town made = value_of(town::make_town({1, 220.0, true}));
  const town::DriveSimulator simulator = drive_through(made, 0, 235.0);
  const std::vector<Pose>& truth = simulator.T_town_vehicle();
  TestContext ctx(2);
  const Trajectory found = value_of(estimate_trajectory(ctx, {}, without_poses(simulator)));
  const std::vector<Pose> poses = poses_of(found);
  EXPECT_GE(found.loop_edges, 1u);
  EXPECT_LT(rmse_m(poses, truth, true), 0.05);
  const Pose by_found = poses.front().inverse() * poses.back();
  const Pose by_truth = truth.front().inverse() * truth.back();
  EXPECT_LT((by_found.translation() - by_truth.translation()).norm(), 0.001 * 235.0);
}

// Of the first two scans, 1 m apart, the best match is that of a vehicle that stands: rings lie on
// rings in a street of bare walls.
TEST(EstimateTrajectoryInATown, BeginsAtFullSpeedInABareStreet) {
  const town::Town made = value_of(town::make_town({1, 2000.0, false}));
  town::DriveOptions options = town::usual_drive(made.options, 2, *town::town_sensor(16));
  options.from_m = 600.0;
  options.length_m = 60.0;
  const town::DriveSimulator simulator = value_of(town::DriveSimulator::make(made, options));
  TestContext ctx(2);
  const Trajectory found = value_of(estimate_trajectory(ctx, {}, without_poses(simulator)));
  EXPECT_LT(rmse_m(poses_of(found), simulator.T_town_vehicle(), true), 0.05);
}

TEST(AlignDriveInATown, AlignsASecondDriveWithoutPosesToTheMapOfTheFirst) {
  const town::Town made = value_of(town::make_town({2, 100.0, false}));
  const town::DriveSimulator first = drive_through(made, 0, 100.0);
  TestContext ctx(2);
  const Drive mapping = town::recorded(first, "mapping", first.T_town_vehicle(), 2);
  const Trajectory trajectory = value_of(estimate_trajectory(ctx, {}, mapping));
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t k = 0; k < mapping.scans.size(); ++k) {
    const Pose T_map_lidar = trajectory.poses[k].T_map_vehicle * mapping.sensor.T_vehicle_lidar;
    const Scan scan = value_of(mapping.store->read(k));
    for (const Eigen::Vector3d& point_m : scan.points_m) points_m.push_back(T_map_lidar * point_m);
  }
  const NdtMap map = ndt_from_points(points_m, trajectory.frame, {}, 2);
  const Sites sites = value_of(choose_sites(ctx, {}, mapping, trajectory));
  const town::DriveSimulator second = drive_through(made, 2, 80.0);
  const Drive drive = without_poses(second);
  const Trajectory own = value_of(estimate_trajectory(ctx, {}, drive));
  const Trajectory found = value_of(align_drive(ctx, {}, drive, own, map, sites));
  EXPECT_LT(rmse_m(poses_of(rebase(found, MapFrame{})), second.T_town_vehicle(), false), 0.05);

  // Known poses with a constant offset: errors against them would contain it.
  const Drive known = town::recorded(second, "town", second.T_town_vehicle(), 2);
  const EstimateTrajectoryOptions as_given{.mode = PoseMode::kGiven};
  Trajectory given = value_of(estimate_trajectory(ctx, as_given, known));
  for (TrajectoryPose& pose : given.poses) pose.T_map_vehicle.translation().x() += 0.3;
  TestContext named(2);
  const Trajectory kept = value_of(align_drive(named, {}, known, given, map, sites));
  EXPECT_EQ(to_bytes(kept), to_bytes(given));
  EXPECT_THAT(named.warnings, testing::ElementsAre(testing::HasSubstr("from the map by 0.3")));
  const AlignDriveOptions options{.subtracts_offset = true};
  const Trajectory moved = value_of(align_drive(ctx, options, known, given, map, sites));
  EXPECT_LT(rmse_m(poses_of(rebase(moved, MapFrame{})), second.T_town_vehicle(), false), 0.05);
}

using testing::HasSubstr;
using testing::Not;

// Root mean square of what ten scans, 10 m, are off.
double drift_m(const UnevenTown& town, const Trajectory& trajectory) {
  constexpr std::size_t kScans = 10;
  const std::vector<Pose>& truth = town.drive.T_town_vehicle();
  double sum_m2 = 0.0;
  for (std::size_t i = 0; i + kScans < truth.size(); ++i) {
    const Pose T_then_now = truth[i].inverse() * truth[i + kScans];
    const Pose found =
        trajectory.poses[i].T_map_vehicle.inverse() * trajectory.poses[i + kScans].T_map_vehicle;
    sum_m2 += (T_then_now.inverse() * found).translation().squaredNorm();
  }
  return std::sqrt(sum_m2 / static_cast<double>(truth.size() - kScans));
}

struct Outcome {
  Trajectory trajectory;
  std::string said;
};

Outcome estimated(const UnevenTown& town, PoseMode mode) {
  TestContext ctx;
  const EstimateTrajectoryOptions options{.mode = mode};
  Outcome outcome{value_of(estimate_trajectory(ctx, options, town.recorded)), ""};
  for (const std::string& warning : ctx.warnings) outcome.said += warning + "\n";
  return outcome;
}

TEST(EstimateUnevenTown, IsNearerToTheTruthWithTurnRates) {
  UnevenTown town(40.0);
  const double even_m = drift_m(town, estimated(town, PoseMode::kEstimate).trajectory);
  town.recorded.turn_rates = town::imu_of(town.drive, 5);
  const double turned_m = drift_m(town, estimated(town, PoseMode::kEstimate).trajectory);
  EXPECT_GT(even_m, 0.08);
  EXPECT_LT(turned_m, 0.03);
}

// Scans that turn unevenly during a sweep fit each other better by other poses than by right ones,
// also when undistorted by these, unless turn rates show the turning.
TEST(EstimateUnevenTown, KeepsGivenPosesWithTurnRatesAndWithout) {
  UnevenTown town(60.0);
  for (const bool has_rates : {false, true}) {
    if (has_rates) town.recorded.turn_rates = town::imu_of(town.drive, 5);
    const Outcome outcome = estimated(town, PoseMode::kAuto);
    EXPECT_THAT(outcome.said, Not(HasSubstr("blur the map")));
    EXPECT_EQ(outcome.trajectory.source, PoseSource::kGiven);
    if (has_rates) {
      EXPECT_THAT(outcome.said, Not(HasSubstr("disagree")));
    }
  }
}

TEST(UndistortedByGiven, KnowsHowUnevenlySweepsTurned) {
  constexpr double kDegree_rad = std::numbers::pi / 180.0;
  UnevenTown town(24.0);
  TestContext ctx;
  const double without_rad = value_of(undistorted_by_given(ctx, town.recorded)).uneven_rad;
  EXPECT_GT(without_rad, 0.2 * kDegree_rad);
  EXPECT_LT(without_rad, 0.4 * kDegree_rad);
  town.recorded.turn_rates = town::imu_of(town.drive, 5);
  EXPECT_EQ(value_of(undistorted_by_given(ctx, town.recorded)).uneven_rad, 0.0);
}

}  // namespace
}  // namespace sightline
