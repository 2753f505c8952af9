#include "passes/factors/virtual/crlb.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "formats/base/random.h"

namespace sightline {
namespace {

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

}  // namespace
}  // namespace sightline
