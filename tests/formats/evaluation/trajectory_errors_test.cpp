#include "formats/evaluation/trajectory_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "formats/base/random.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

TimedPose at(std::int64_t stamp_ms, double x_m, double y_m = 0.0, double yaw_rad = 0.0) {
  TimedPose pose{stamp_ms * 1'000'000};
  pose.T_world_vehicle.linear() =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.T_world_vehicle.translation() = Eigen::Vector3d(x_m, y_m, 0.0);
  return pose;
}

TEST(TrajectoryErrors, AreThoseOfASmallExample) {
  const std::vector<TimedPose> reference = {at(0, 0), at(100, 1), at(200, 2), at(300, 3)};
  const std::vector<TimedPose> poses = {at(0, 0, 0.1), at(100, 1), at(200, 2, 0, 0.5),
                                        at(300, 3, -0.3)};
  const TrajectoryErrors errors = value_of(trajectory_errors(reference, poses, {}));
  EXPECT_EQ(errors.pair_count, 4U);
  EXPECT_DOUBLE_EQ(errors.absolute_m.mean, 0.1);
  EXPECT_DOUBLE_EQ(errors.absolute_m.rmse, std::sqrt(0.1 / 4.0));
  EXPECT_DOUBLE_EQ(errors.absolute_m.median, 0.05);
  EXPECT_DOUBLE_EQ(errors.absolute_m.max, 0.3);
  EXPECT_DOUBLE_EQ(errors.absolute_m.min, 0.0);
  EXPECT_NEAR(errors.absolute_deg.max, 0.5 * 180.0 / std::numbers::pi, 1e-9);
  // From the third pose, turned by half a radian, the step ahead is seen elsewhere.
  EXPECT_EQ(errors.relative_m.count, 3U);
  EXPECT_NEAR(errors.relative_m.min, 0.0, 1e-12);
  EXPECT_EQ(value_of(trajectory_errors(reference, poses, {.delta = 2})).relative_m.count, 1U)
      << "steps of two frames follow each other: 0 to 2";
}

TEST(TrajectoryErrors, PairEachPoseOfTheShorterListWithTheNearestInTime) {
  const std::vector<TimedPose> reference = {at(0, 0), at(96, 1), at(108, 5), at(200, 2)};
  const std::vector<TimedPose> poses = {at(100, 1.5), at(211, 7)};
  const TrajectoryErrors errors = value_of(trajectory_errors(reference, poses, {}));
  EXPECT_EQ(errors.pair_count, 1U) << "11 ms are too far apart";
  EXPECT_DOUBLE_EQ(errors.absolute_m.mean, 0.5) << "the pose at 96 ms is nearer than that at 108";
  const TrajectoryErrors swapped = value_of(trajectory_errors(poses, reference, {}));
  EXPECT_DOUBLE_EQ(swapped.absolute_m.mean, 0.5);
}

TEST(TrajectoryErrors, OverMetresAreAlongThePosesFound) {
  std::vector<TimedPose> poses;
  for (int i = 0; i < 21; ++i) poses.push_back(at(100 * i, 0.5 * i));
  const TrajectoryErrors errors =
      value_of(trajectory_errors(poses, poses, {.delta = 2.0, .unit = DeltaUnit::kMetres}));
  EXPECT_EQ(errors.relative_m.count, 4U) << "from 2 m to 4, 6, 8 and 10 m";
  EXPECT_EQ(errors.relative_m.max, 0.0);
}

TEST(TrajectoryErrors, DisappearWhereTheReferenceIsOnlyMovedAndThePosesAreAligned) {
  Random random(5);
  Pose moved = Pose::Identity();
  moved.linear() = Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, -1).normalized()).matrix();
  moved.translation() = Eigen::Vector3d(500'000.0, -20.0, 3.0);
  std::vector<TimedPose> reference;
  std::vector<TimedPose> poses;
  for (int i = 0; i < 50; ++i) {
    poses.push_back(at(100 * i, i, random.normal(), random.normal()));
    reference.push_back({poses.back().stamp_ns, moved * poses.back().T_world_vehicle});
  }
  EXPECT_GT(value_of(trajectory_errors(reference, poses, {})).absolute_m.min, 1000.0);
  const TrajectoryErrors aligned =
      value_of(trajectory_errors(reference, poses, {.is_aligned = true}));
  EXPECT_LT(aligned.absolute_m.max, 1e-6);
  EXPECT_LT(aligned.absolute_deg.max, 1e-5);
  EXPECT_TRUE(aligned.T_reference_world.isApprox(moved, 1e-9));
  EXPECT_LT(value_of(trajectory_errors(reference, poses, {})).relative_m.max, 1e-6)
      << "steps do not depend on the world";
}

TEST(TrajectoryErrors, AreRefusedWithoutPairsAndWhereNoRotationFollows) {
  const std::vector<TimedPose> first = {at(0, 0), at(100, 1), at(200, 2)};
  const std::vector<TimedPose> later = {at(5000, 0), at(5100, 1)};
  const Result<TrajectoryErrors> apart = trajectory_errors(first, later, {});
  ASSERT_FALSE(apart);
  EXPECT_EQ(apart.error().code, ErrorCode::kMismatchedInputs);
  EXPECT_FALSE(trajectory_errors({}, first, {}));
  const Result<TrajectoryErrors> line = trajectory_errors(first, first, {.is_aligned = true});
  ASSERT_FALSE(line);
  EXPECT_THAT(line.error().message, HasSubstr("on one line"));
}

}  // namespace
}  // namespace sightline
