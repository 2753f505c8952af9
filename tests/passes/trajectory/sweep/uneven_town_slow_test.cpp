#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "passes/trajectory/estimate_trajectory.h"
#include "tests/passes/trajectory/sweep/uneven_town.h"

namespace sightline {
namespace {

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
  Outcome outcome;
  PassContext ctx;
  ctx.warning_sink = [&](const std::string& message) { outcome.said += message + "\n"; };
  EstimateTrajectoryOptions options;
  options.mode = mode;
  const Result<Trajectory> trajectory = estimate_trajectory(ctx, options, town.recorded);
  EXPECT_TRUE(trajectory.has_value());
  if (trajectory) outcome.trajectory = *trajectory;
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

// Scans that are distorted unevenly contradict poses that are right.
TEST(EstimateUnevenTown, KeepsGivenPosesWhereTurnRatesSpeakForThem) {
  UnevenTown town(60.0);
  EXPECT_THAT(estimated(town, PoseMode::kAuto).said, HasSubstr("disagree"));
  town.recorded.turn_rates = town::imu_of(town.drive, 5);
  const Outcome outcome = estimated(town, PoseMode::kAuto);
  EXPECT_THAT(outcome.said, Not(HasSubstr("disagree")));
  EXPECT_EQ(outcome.trajectory.source, PoseSource::kGiven);
}

}  // namespace
}  // namespace sightline
