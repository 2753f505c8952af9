#include "passes/trajectory/given/sharpening.h"

#include <gtest/gtest.h>
#include <numbers>

#include "tests/support/box_world.h"

// Which stretches are doubtful, by given poses and an odometry alone.

namespace sightline {
namespace {

constexpr double kDegree_rad = std::numbers::pi / 180.0;

// A straight way of 1 m a step, whose given poses bend by 0.05 degrees a step: 0.5 over 10 m.
struct TurnedWay {
  Odometry odometry;
  GivenPoses given;

  explicit TurnedWay(double step_sigma_m) {
    for (int k = 0; k < 50; ++k) {
      odometry.append(pose_at(k, 0.0, 0.0), k == 0 ? 0.0 : 1.0, true, {});
      odometry.constraint.back().sigma_m = step_sigma_m;
      given.emplace_back(k == 0 ? Pose::Identity()
                                : *given.back() * pose_at(1.0, 0.0, 0.05 * kDegree_rad));
    }
  }
  [[nodiscard]] WayStretch stretch() const { return stretches_of(given, odometry, {}).front(); }
};

TEST(WayStretch, IsDoubtfulWhereGivenPosesTurnOtherwiseThanMatchedScans) {
  const WayStretch stretch = TurnedWay(0.003).stretch();
  EXPECT_TRUE(stretch.turns_otherwise);
  EXPECT_NEAR(stretch.off_rad, 0.5 * kDegree_rad, 0.02 * kDegree_rad);
}

// Ten steps of 9 mm are off by 2.8 cm, which is 0.16 degrees 10 m away; three times that is
// allowed beside 0.2 degrees.
TEST(WayStretch, IsNotDoubtfulWithinTheErrorsOfMatches) {
  EXPECT_FALSE(is_doubtful(TurnedWay(0.009).stretch()));
}

TEST(WayStretch, IsNotDoubtfulWhereScansDoNotConstrainSteps) {
  TurnedWay way(0.003);
  for (std::size_t k = 5; k < 50; k += 5) way.odometry.constraint[k].forecast_motions(0, 0) = 1.0;
  EXPECT_FALSE(is_doubtful(way.stretch()));
}

TEST(MotionOverlaps, ContradictTheMotionOfMuchLessOverlap) {
  EXPECT_TRUE((MotionOverlaps{0.3, 0.6}.contradict_given()));
  EXPECT_FALSE((MotionOverlaps{0.58, 0.6}.contradict_given()));
  EXPECT_FALSE((MotionOverlaps{0.1, 0.3}.contradict_given())) << "scans that hardly overlap";
  EXPECT_TRUE((MotionOverlaps{0.4, 0.16}.contradict_matched()));
  EXPECT_FALSE((MotionOverlaps{0.58, 0.6}.contradict_matched()));
  EXPECT_FALSE((MotionOverlaps{}.contradict_given()));
  EXPECT_FALSE((MotionOverlaps{}.contradict_matched()));
}

}  // namespace
}  // namespace sightline
