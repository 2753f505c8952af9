#include "passes/matching/match_starts.h"

#include <gtest/gtest.h>

#include "tests/passes/matching/random_scene.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

TEST(PredictedPose, GoesOnAsTheLastStepWent) {
  Random random(3);
  const Pose T_map_before = random_pose(random, 5.0, 1.0);
  const Pose motion = random_pose(random, 1.0, 0.2);
  const Pose T_map_last = T_map_before * motion;
  EXPECT_TRUE(predicted_pose(T_map_last, motion).isApprox(T_map_last * motion, 1e-9));
  EXPECT_TRUE(predicted_pose(T_map_last, motion, 0.0).isApprox(T_map_last, 1e-12));
}

TEST(PredictedPose, TwiceTheTimeIsTwiceTheWayAndTheTurn) {
  const Pose prediction = predicted_pose(Pose::Identity(), pose_at(1.0, 0.0, 0.1), 2.0);
  EXPECT_TRUE(prediction.translation().isApprox(Eigen::Vector3d(2.0, 0.0, 0.0), 1e-12));
  EXPECT_NEAR(Eigen::AngleAxisd(prediction.linear()).angle(), 0.2, 1e-12);
}

}  // namespace
}  // namespace sightline
