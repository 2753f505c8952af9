
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "formats/base/random.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

Eigen::Vector3d random_axis(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

TEST(Rotation, AQuarterTurnAboutZTakesXToY) {
  const Eigen::Matrix3d quarter =
      rotation_matrix({Eigen::Vector3d::UnitZ(), 0.5 * std::numbers::pi});
  EXPECT_LT((quarter * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_NEAR(rotation_angle_rad(quarter), 0.5 * std::numbers::pi, 1e-15);
  EXPECT_EQ(rotation_angle_rad(Eigen::Matrix3d::Identity()), 0.0);
  EXPECT_EQ(rotation_vector(Eigen::Matrix3d::Identity()), Eigen::Vector3d(0.0, 0.0, 0.0));
}

TEST(Rotation, AgreesWithEigensAxisAndAngle) {
  Random random(1);
  for (int trial = 0; trial < 10000; ++trial) {
    const double scale = trial % 3 == 0 ? 1e-7 : 1.0;
    const AxisAngle turn{random_axis(random), scale * random.uniform(0.0, std::numbers::pi)};
    const Eigen::Matrix3d matrix = rotation_matrix(turn);
    const Eigen::Matrix3d of_eigen =
        Eigen::AngleAxisd(turn.angle_rad, turn.axis).toRotationMatrix();
    ASSERT_LT((matrix - of_eigen).cwiseAbs().maxCoeff(), 2e-15);
    ASSERT_NEAR(rotation_angle_rad(of_eigen), turn.angle_rad, 1e-14);
    ASSERT_LT((rotation_vector(of_eigen) - turn.angle_rad * turn.axis).norm(), 1e-13);
    const AxisAngle back = axis_angle(of_eigen);
    ASSERT_LT((rotation_matrix(back) - of_eigen).cwiseAbs().maxCoeff(), 4e-15);
  }
}

TEST(Rotation, AHalfTurnKeepsItsAxisUpToSign) {
  Random random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const Eigen::Vector3d axis = random_axis(random);
    const AxisAngle turn = axis_angle(rotation_matrix({axis, std::numbers::pi}));
    ASSERT_NEAR(turn.angle_rad, std::numbers::pi, 1e-14);
    ASSERT_NEAR(std::abs(turn.axis.dot(axis)), 1.0, 1e-14);
  }
}

TEST(Rotation, DirectionsHaveLengthOne) {
  EXPECT_EQ(direction_of(0.0, 0.0), Eigen::Vector3d(1.0, 0.0, 0.0));
  Random random(3);
  for (int trial = 0; trial < 1000; ++trial) {
    const double azimuth_rad = random.uniform(-10.0, 10.0);
    const double elevation_rad = random.uniform(-1.5, 1.5);
    const Eigen::Vector3d direction = direction_of(azimuth_rad, elevation_rad);
    ASSERT_NEAR(direction.norm(), 1.0, 1e-15);
    ASSERT_NEAR(direction.z(), std::sin(elevation_rad), 1e-15);
    ASSERT_NEAR(direction.y() * std::cos(azimuth_rad), direction.x() * std::sin(azimuth_rad),
                1e-15);
  }
}

TEST(Rotation, BetweenPosesItTurnsEvenlyTheShorterWay) {
  Random random(4);
  for (int trial = 0; trial < 10000; ++trial) {
    Pose from = Pose::Identity();
    Pose to = Pose::Identity();
    from.linear() = rotation_matrix({random_axis(random), random.uniform(0.0, 3.0)});
    const double turn_rad = random.uniform(0.0, trial % 2 == 0 ? 3.0 : 1e-6);
    to.linear() = from.linear() * rotation_matrix({random_axis(random), turn_rad});
    const double fraction = random.uniform();
    const Pose between = interpolate(from, to, fraction);
    const Eigen::Matrix3d of_eigen = Eigen::Quaterniond(from.linear())
                                         .slerp(fraction, Eigen::Quaterniond(to.linear()))
                                         .toRotationMatrix();
    ASSERT_LT((between.linear() - of_eigen).cwiseAbs().maxCoeff(), 1e-14);
    // Of nine elements, each through a quaternion and back: a few units in the last place.
    ASSERT_LT((interpolate(from, to, 0.0).linear() - from.linear()).cwiseAbs().maxCoeff(), 2e-15);
    ASSERT_LT((interpolate(from, to, 1.0).linear() - to.linear()).cwiseAbs().maxCoeff(), 2e-15);
  }
}

}  // namespace
}  // namespace sightline
