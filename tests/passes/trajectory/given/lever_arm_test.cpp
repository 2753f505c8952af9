#include "passes/trajectory/given/lever_arm.h"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "formats/base/random.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

// A way of 80 m with a ramp of 5 degrees in its middle. Matched poses are those of the sensor, with
// errors of 5 mm; given ones those of a vehicle on the ground, whose sensor is `arm_m` from there.
struct RampWay {
  Odometry odometry;
  GivenPoses given;

  explicit RampWay(const Eigen::Vector3d& arm_m, double ramp_deg = 5.0) {
    Random random(2);
    for (int k = 0; k < 80; ++k) {
      Pose pose = pose_at(k, 0.0, 0.0);
      const bool is_on_ramp = k >= 30 && k < 50;
      if (is_on_ramp) {
        pose.rotate(
            Eigen::AngleAxisd(-ramp_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()));
      }
      given.emplace_back(pose);
      Pose sensor = pose * Eigen::Translation3d(arm_m);
      sensor.translation().x() += 0.005 * random.normal();
      odometry.append(sensor, k == 0 ? 0.0 : 1.0, true, {});
    }
  }
};

TEST(LeverArm, OfASensorAboveTheVehiclesOriginIsFoundOnARamp) {
  const RampWay way({0.0, 0.0, 1.8});
  const std::optional<Eigen::Vector3d> arm_m = lever_arm_m(Drive{}, way.given, way.odometry);
  ASSERT_TRUE(arm_m.has_value());
  EXPECT_NEAR(arm_m->z(), 1.8, 0.1);
}

// Along the axis of all turning an arm moves nothing.
TEST(LeverArm, AcrossTheWayIsNotKnownFromPitch) {
  const RampWay way({0.0, 0.7, 1.8});
  const std::optional<Eigen::Vector3d> arm_m = lever_arm_m(Drive{}, way.given, way.odometry);
  ASSERT_TRUE(arm_m.has_value());
  EXPECT_NEAR(arm_m->y(), 0.0, 1e-6);
}

TEST(LeverArm, IsNoneWhereTheSensorIsWhereItIsSaidToBe) {
  const RampWay way({0.0, 0.0, 0.0});
  EXPECT_FALSE(lever_arm_m(Drive{}, way.given, way.odometry).has_value());
}

TEST(LeverArm, IsNoneOnALevelRoad) {
  const RampWay way({0.0, 0.0, 1.8}, 0.0);
  EXPECT_FALSE(lever_arm_m(Drive{}, way.given, way.odometry).has_value());
}

TEST(LeverArm, IsNoneWhereGivenPosesAreWrongInOtherWays) {
  RampWay way({0.0, 0.0, 0.0});
  for (std::size_t k = 0; k < way.given.size(); ++k) {
    way.given[k]->translation().x() *= 1.05;
    way.given[k]->translation().y() += 0.3 * std::sin(0.1 * static_cast<double>(k));
  }
  EXPECT_FALSE(lever_arm_m(Drive{}, way.given, way.odometry).has_value());
}

}  // namespace
}  // namespace sightline
