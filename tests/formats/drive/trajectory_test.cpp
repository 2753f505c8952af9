#include "formats/drive/trajectory.h"
#include "formats/drive/unconstrained_stretches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "formats/base/random.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Pose turned(double yaw_rad, const Eigen::Vector3d& position_m) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = position_m;
  return pose;
}

Trajectory two_poses() {
  Trajectory trajectory;
  trajectory.frame.origin_world_m = {64.0, -128.0, 0.0};
  trajectory.source = PoseSource::kRefined;
  trajectory.odometry_edges = 1;
  trajectory.prior_edges = 2;
  trajectory.rms_translation_residual_m = 0.01;
  trajectory.poses = {{3, 100, turned(0.0, {1.0, 2.0, 3.0})},
                      {4, 200, turned(0.5, {2.0, 2.0, 3.0})}};
  trajectory.poses[1].piece = 1;
  trajectory.poses[1].overlap = 0.75;
  PoseCovariance::Matrix covariance = PoseCovariance::Matrix::Zero();
  covariance.diagonal().setConstant(0.04);
  covariance(0, 5) = covariance(5, 0) = 0.01;
  trajectory.poses[1].covariance = covariance;
  return trajectory;
}

TEST(Trajectory, SurvivesTheDisk) { expect_survives_disk(two_poses()); }

TEST(Trajectory, KeepsTheSignOfAZeroInACovariance) {
  Trajectory trajectory = two_poses();
  PoseCovariance::Matrix zeros = PoseCovariance::Matrix::Zero();
  zeros(3, 3) = -0.0;
  trajectory.poses[0].covariance = zeros;
  expect_survives_disk(trajectory);
  EXPECT_TRUE(std::signbit(trajectory.poses[0].covariance(3, 3)));
}

TEST(Trajectory, IsPrintedWithItsPosesAndWhereTheyCameFrom) {
  const Table table = dump(two_poses());
  EXPECT_EQ(table.columns, (std::vector<std::string>{
                               "recording_index", "stamp_ns", "x_m", "y_m", "z_m", "qx", "qy", "qz",
                               "qw", "sigma_x_m", "sigma_y_m", "sigma_z_m", "sigma_rx_rad",
                               "sigma_ry_rad", "sigma_rz_rad", "piece", "overlap"}));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[1][0], Cell(std::int64_t{4}));
  EXPECT_EQ(table.rows[1][2], Cell(2.0));
  EXPECT_NEAR(std::get<double>(table.rows[1][7]), std::sin(0.25), 1e-15);
  EXPECT_EQ(table.rows[0][9], Cell(0.0));
  EXPECT_EQ(table.rows[1][9], Cell(0.2));
  EXPECT_EQ(table.rows[0][16], Cell(std::string()));  // not measured
  EXPECT_EQ(table.rows[1][15], Cell(std::int64_t{1}));
  EXPECT_EQ(table.rows[1][16], Cell(0.75));
  EXPECT_EQ(table.facts[3].second, Cell(std::string("refined")));
}

TEST(Trajectory, SaysWhichScansAreNotLaid) {
  Trajectory trajectory = two_poses();
  EXPECT_EQ(dump(trajectory).columns.back(), "overlap");
  trajectory.poses[1].is_laid = false;
  expect_survives_disk(trajectory);
  const Trajectory again = value_of(from_bytes<Trajectory>(to_bytes(trajectory)));
  EXPECT_TRUE(again.poses[0].is_laid);
  EXPECT_FALSE(again.poses[1].is_laid);
  EXPECT_EQ(again.poses[1].piece, 1u);
  const Table table = dump(trajectory);
  EXPECT_EQ(table.columns.back(), "is_laid");
  EXPECT_EQ(table.rows[0].back(), Cell(std::int64_t{1}));
  EXPECT_EQ(table.rows[1].back(), Cell(std::int64_t{0}));
}

// Covariances as of a vehicle that drives ten steps of 1 m along x, the last eight of them weak.
Trajectory weak_along() {
  Trajectory trajectory;
  for (std::uint32_t i = 0; i <= 10; ++i) {
    TrajectoryPose pose{7 + i, 100 * i, turned(0.0, {1.0 * i, 0.0, 0.0})};
    PoseCovariance::Matrix covariance = PoseCovariance::Matrix::Zero();
    covariance(0, 0) = i < 3 ? 0.01 : 0.01 + 0.25 * (i - 2) * (i - 2);
    pose.covariance = covariance;
    if (i >= 3) pose.unconstrained = {true, false, false, Substitute::kConstantSpeed};
    trajectory.poses.push_back(pose);
  }
  return trajectory;
}

TEST(Trajectory, KeepsWhatScansDoNotConstrain) {
  const Trajectory trajectory = weak_along();
  expect_survives_disk(trajectory);
  const Trajectory again = value_of(from_bytes<Trajectory>(to_bytes(trajectory)));
  EXPECT_EQ(again.poses[2].unconstrained, Unconstrained());
  EXPECT_EQ(again.poses[3].unconstrained, trajectory.poses[3].unconstrained);
  EXPECT_EQ(again.poses[3].piece, 0U);
  EXPECT_TRUE(again.poses[3].is_laid);
  const Table table = dump(trajectory);
  EXPECT_EQ(table.columns.back(), "substitute");
  EXPECT_EQ(table.rows[3].back(), Cell(std::string("constant-speed")));
  EXPECT_EQ(table.rows[2][table.rows[2].size() - 4], Cell(std::int64_t{0}));
}

// A constrained pose and its bytes are those of a trajectory that knows nothing of such poses.
TEST(Trajectory, HasNoOtherBytesWhereScansConstrainAll) {
  const auto bytes_of = [](const TrajectoryPose& pose) {
    ByteWriter writer;
    encode(pose, writer);
    return writer.take();
  };
  const TrajectoryPose pose = two_poses().poses[1];
  const std::vector<std::byte> bytes = bytes_of(pose);
  const std::size_t piece = bytes.size() - sizeof(double) - sizeof(std::uint32_t);
  EXPECT_EQ(bytes[piece], std::byte{1});
  for (std::size_t i = 1; i < 4; ++i) EXPECT_EQ(bytes[piece + i], std::byte{0});
}

TEST(Trajectory, IsRefusedWithASubstituteThatNothingNeeds) {
  expect_refused<Trajectory>(
      weak_along(), {[](Trajectory& needless) {
                       needless.poses[0].unconstrained.substitute = Substitute::kWheelSpeed;
                     },
                     [](Trajectory& unknown) {
                       unknown.poses[5].unconstrained.substitute = static_cast<Substitute>(7);
                     },
                     [](Trajectory& nameless) { nameless.notices.emplace_back(); }});
}

TEST(UnconstrainedStretches, HaveTheirWayAndTheGrowthOfTheVariance) {
  Trajectory trajectory = weak_along();
  std::vector<UnconstrainedStretch> stretches = unconstrained_stretches(trajectory);
  ASSERT_EQ(stretches.size(), 1U);
  EXPECT_EQ(stretches[0].first_scan, 10U);
  EXPECT_EQ(stretches[0].last_scan, 17U);
  EXPECT_DOUBLE_EQ(stretches[0].way_m, 8.0);
  EXPECT_NEAR(stretches[0].sigma_m.value(), 0.5 * 8.0, 1e-12);
  EXPECT_NEAR(unconstrained_sigmas_m(trajectory)[4].value(), 0.5 * 2.0, 1e-12);
  EXPECT_EQ(stretches[0].end_map_m.x(), 10.0);
  trajectory.poses[6].unconstrained = {};
  for (std::size_t i = 7; i <= 10; ++i) {
    trajectory.poses[i].unconstrained.substitute = Substitute::kGivenPoses;
  }
  stretches = unconstrained_stretches(trajectory);
  ASSERT_EQ(stretches.size(), 2U);
  EXPECT_FALSE(stretches[1].is_assumed());
  EXPECT_EQ(stretches[1].sigma_m, std::nullopt);
  EXPECT_EQ(substitute_text(stretches[1]), "the given poses are used");
}

TEST(Trajectory, KeepsItsNotices) {
  Trajectory trajectory = two_poses();
  trajectory.notices = {{"given-poses-disagree", "they disagree", 2, 3, 4, 69.1, "m"}};
  expect_survives_disk(trajectory);
  const Trajectory again = value_of(from_bytes<Trajectory>(to_bytes(trajectory)));
  EXPECT_EQ(again.notices, trajectory.notices);
}

TEST(Trajectory, RefusesPiecesOutOfOrderAndOverlapsThatAreNoShares) {
  expect_refused<Trajectory>(two_poses(),
                             {[](Trajectory& skipped) { skipped.poses[1].piece = 2; },
                              [](Trajectory& too_much) { too_much.poses[1].overlap = 1.5; }});
}

TEST(Trajectory, ToldInAnotherFrameStaysWhereItIsInTheWorld) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Trajectory before = two_poses();
    MapFrame to;
    for (int axis = 0; axis < 3; ++axis) {
      to.origin_world_m[axis] = 64.0 * static_cast<double>(random.below(100000));
    }
    const Trajectory after = rebase(before, to);
    ASSERT_EQ(after.frame, to);
    for (std::size_t k = 0; k < before.poses.size(); ++k) {
      const Eigen::Vector3d world_before =
          before.poses[k].T_map_vehicle.translation() + before.frame.origin_world_m;
      const Eigen::Vector3d world_after =
          after.poses[k].T_map_vehicle.translation() + to.origin_world_m;
      ASSERT_LT((world_before - world_after).norm(), 1e-8);
      ASSERT_EQ(before.poses[k].T_map_vehicle.linear(), after.poses[k].T_map_vehicle.linear());
    }
  }
}

TEST(Trajectory, RefusesWhatIsNoTrajectory) {
  expect_refused<Trajectory>(
      two_poses(),
      {[](Trajectory& sheared) { sheared.poses[1].T_map_vehicle.linear()(0, 0) += 0.01; },
       [](Trajectory& backwards) { backwards.poses[1].stamp_ns = 99; },
       [](Trajectory& repeated) { repeated.poses[1].recording_index = 3; },
       [](Trajectory& residual) {
         residual.rms_rotation_residual_rad = std::numeric_limits<double>::quiet_NaN();
       },
       [](Trajectory& source) { source.source = static_cast<PoseSource>(7); }});
}

}  // namespace
}  // namespace sightline
