#include "passes/trajectory/following/scan_before.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

// Poles beside a road of 100 m, of 20 returns each; those ahead of `from_m` by at most 40 m, in the
// axes of a sensor there.
std::vector<Eigen::Vector3d> poles_from(double from_m, double every_m) {
  Random random(5);
  std::vector<Eigen::Vector3d> points_m;
  for (double x_m = 0.0; x_m<100.0; x_m += every_m> 0.0 ? every_m : random.uniform(1.0, 5.0)) {
    const double y_m = every_m > 0.0 ? 5.0 : random.uniform(-8.0, 8.0);
    if (std::abs(x_m - from_m) > 40.0) continue;
    for (int i = 0; i < 20; ++i) points_m.emplace_back(x_m - from_m, y_m, 0.2 * i);
  }
  return points_m;
}

Pose ahead_by(double x_m) { return pose_at(x_m, 0.0, 0.0); }

std::optional<double> rival_m(double from_m, double to_m, double claimed_m, double every_m = 0.0,
                              double farthest_m = 30.0) {
  ScanBefore before;
  before.set(poles_from(from_m, every_m), ahead_by(from_m));
  return before.rival_m(poles_from(to_m, every_m), ahead_by(from_m + claimed_m),
                        Eigen::Vector3d::UnitX(), farthest_m);
}

TEST(ScanBefore, ShowsHowFarAWrongStepIsOff) {
  for (const double claimed_m : {0.0, 4.0, 25.0}) {
    const std::optional<double> off_m = rival_m(30.0, 43.0, claimed_m);
    ASSERT_TRUE(off_m) << claimed_m;
    EXPECT_NEAR(*off_m, 13.0 - claimed_m, 0.31) << claimed_m;
  }
}

TEST(ScanBefore, ShowsNothingElseOfARightStep) {
  EXPECT_FALSE(rival_m(30.0, 43.0, 13.0));
  EXPECT_FALSE(rival_m(30.0, 43.0, 12.8)) << "a match is off by less";
}

TEST(ScanBefore, ShowsNoRivalThatIsNearOrThatTheVehicleCannotHaveMovedTo) {
  EXPECT_FALSE(rival_m(30.0, 43.0, 10.5)) << "2.5 m off";
  EXPECT_FALSE(rival_m(30.0, 31.0, 10.0)) << "it hardly moved";
  EXPECT_FALSE(rival_m(30.0, 43.0, 0.0, 0.0, 12.0)) << "too fast";
}

TEST(ScanBefore, ShowsNoRivalThatIsNotClearlyBetter) {
  EXPECT_FALSE(rival_m(30.0, 40.0, 0.0, 10.0)) << "poles 10 m apart";
}

// Half of the returns are enough: a street half of whose walls change at a corner is not elsewhere.
TEST(ScanBefore, ShowsNoRivalOfAPlaceWhereHalfOfTheReturnsMeet) {
  const auto both_from = [](double from_m) -> std::vector<Eigen::Vector3d> {
    std::vector<Eigen::Vector3d> points_m = poles_from(from_m, 0.0);
    for (int i = 0; i < 6; ++i) {
      const std::vector<Eigen::Vector3d> even_m = poles_from(from_m, 10.0);
      points_m.insert(points_m.end(), even_m.begin(), even_m.end());
    }
    return points_m;
  };
  ScanBefore before;
  before.set(both_from(30.0), ahead_by(30.0));
  EXPECT_GT(*before.overlap(both_from(40.0), ahead_by(30.0)), 0.5);
  EXPECT_GT(*before.overlap(both_from(40.0), ahead_by(40.0)), 0.8);
  EXPECT_FALSE(before.rival_m(both_from(40.0), ahead_by(30.0), Eigen::Vector3d::UnitX(), 30.0));
}

TEST(ScanBefore, ShowsNothingWithoutUprightReturns) {
  ScanBefore before;
  before.set({}, Pose::Identity());
  EXPECT_FALSE(
      before.rival_m(poles_from(30.0, 0.0), Pose::Identity(), Eigen::Vector3d::UnitX(), 30.0));
}

}  // namespace
}  // namespace sightline
