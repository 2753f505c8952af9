#include "passes/trajectory/graph/given_steps.h"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "tests/support/box_world.h"

namespace sightline {
namespace {

constexpr std::size_t kScans = 60;

// A straight way of 1 m a step. Given poses move 2 % farther than matched ones.
struct GivenWay {
  Odometry odometry;
  GivenPoses given;

  GivenWay() {
    for (std::size_t k = 0; k < kScans; ++k) {
      const auto x_m = static_cast<double>(k);
      odometry.append(pose_at(x_m, 0.0, 0.0), k == 0 ? 0.0 : 1.0, true, {});
      given.emplace_back(pose_at(1.02 * x_m, 0.0, 0.0));
    }
  }
  // The steps to these scans are given ones in the direction ahead.
  void use_given(std::size_t first, std::size_t last) {
    for (std::size_t k = first; k <= last; ++k) {
      StepConstraint& step = odometry.constraint[k];
      step.forecast = Forecast::kGiven;
      step.forecast_motions(0, 0) = 1.0;
    }
  }
};

TEST(GivenDrift, IsTheMedianDifferenceOfGivenAndMatchedMotions) {
  const GivenWay way;
  const GivenDrift drift = given_drift({}, way.given, way.odometry);
  EXPECT_NEAR(drift.sigma_m, 0.02 * 10.0 / std::sqrt(10.0) / 1.538, 1e-6);
  EXPECT_NEAR(drift.sigma_rad, 0.0, 1e-9);
}

TEST(GivenDrift, LeavesOutStepsThatScansDoNotConstrain) {
  GivenWay way;
  for (std::size_t k = 20; k < kScans; ++k) way.given[k]->translation().y() = 0.5 * double(k);
  way.use_given(20, kScans - 1);
  EXPECT_NEAR(given_drift({}, way.given, way.odometry).sigma_m, 0.041, 0.001);
}

TEST(GivenDrift, IsAtMostWhatTheOptionsSay) {
  GivenWay way;
  const EstimateTrajectoryOptions options{.prior_sigma_m = 0.1, .prior_sigma_deg = 0.5};
  EXPECT_NEAR(given_drift(options, way.given, way.odometry).sigma_m, 0.1 * std::sqrt(0.02), 1e-9);
  way.use_given(1, kScans - 1);
  const GivenDrift unknown = given_drift(options, way.given, way.odometry);
  EXPECT_NEAR(unknown.sigma_rad, std::sqrt(0.02) * 0.5 * std::numbers::pi / 180.0, 1e-9);
}

// The sensor's x axis points to the vehicle's left.
TEST(GivenDrift, IsAddedInTheSensorsAxesWhereGivenStepsAreUsed) {
  GivenWay way;
  way.use_given(3, 4);
  Drive drive;
  drive.sensor.T_vehicle_lidar.linear() = pose_at(0.0, 0.0, 0.5 * std::numbers::pi).linear();
  std::vector<GraphEdge> steps = {{0, 1}, {1, 2}};
  add_given_drift(drive, way.odometry, {0.3, 0.01}, {0, 2, 6}, steps);
  EXPECT_TRUE(steps[0].more.isZero(0.0));
  Matrix6d expected = Matrix6d::Zero();
  expected(1, 1) = 2.0 * 0.3 * 0.3;
  EXPECT_TRUE(steps[1].more.isApprox(expected, 1e-9)) << steps[1].more;
}

TEST(GivenDrift, OfHeadingIsThatOfTheGivenHeading) {
  GivenWay way;
  StepConstraint& step = way.odometry.constraint[1];
  step.forecast = Forecast::kGiven;
  step.forecast_motions(2, 2) = 1.0;
  std::vector<GraphEdge> steps = {{0, 1}};
  add_given_drift(Drive{}, way.odometry, {0.3, 0.01}, {0, 1}, steps);
  EXPECT_NEAR(steps[0].more(5, 5), 1e-4, 1e-12);
  EXPECT_NEAR(steps[0].more.cwiseAbs().sum(), 1e-4, 1e-12);
}

// Poses are not moved by what is only forecast at constant speed.
TEST(GivenMotions, AreNoneWithoutGivenSteps) {
  GivenWay way;
  way.use_given(5, 5);
  EXPECT_FALSE(given_motions(Drive{}, way.odometry, 5).isZero(0.0));
  way.odometry.constraint[5].forecast = Forecast::kSteady;
  EXPECT_TRUE(given_motions(Drive{}, way.odometry, 5).isZero(0.0));
}

}  // namespace
}  // namespace sightline
