#include <gtest/gtest.h>
#include <cmath>

#include "formats/base/random.h"
#include "tests/bench/integrity/closed_loop.h"
#include "tests/bench/integrity/loop_table.h"
#include "tests/bench/integrity/pose_filter.h"

namespace sightline {
namespace {

constexpr bool kAll[3] = {true, true, true};

// A vehicle that drives a circle with exact sensors but for noise, scale and bias, and matches that
// are as wrong as they say.
TEST(PoseFilter, IsAsWrongAsItSaysWhereMatchesAreIndependent) {
  Consistency fused;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    PlanarPose truth(0.0, 0.0, 0.1);
    PoseFilter filter(truth + PlanarPose(0.05 * random.normal(), 0.05 * random.normal(),
                                         0.005 * random.normal()));
    const Eigen::Vector3d sigmas(0.1, 0.03, 0.004);
    const double scale = 1.0 + 0.02 * random.normal();
    const double bias_rad_per_s = 0.0005 * random.normal();
    for (int k = 0; k < 150; ++k) {
      const double turn_rad = 0.01;
      const double heading_rad = truth.z() + 0.5 * turn_rad;
      truth += PlanarPose(std::cos(heading_rad), std::sin(heading_rad), turn_rad);
      truth.z() = wrapped_rad(truth.z());
      filter.predict({0.1, 10.0 * scale + 0.1 * random.normal(),
                      (turn_rad + 0.0007 * random.normal()) / 0.1 + bias_rad_per_s});
      const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
      filter.update(truth + sigmas.cwiseProduct(noise),
                    sigmas.cwiseAbs2().cwiseInverse().asDiagonal());
      if (k >= 20) fused.add(difference(filter.pose(), truth), filter.covariance(), kAll);
    }
  }
  EXPECT_GT(fused.per_freedom(), 0.6);
  EXPECT_LT(fused.per_freedom(), 1.2);
}

TEST(PoseFilter, IgnoresWhatHasNoInformation) {
  PoseFilter filter(PlanarPose(0.0, 0.0, 0.0));
  filter.predict({0.1, 10.0, 0.0});
  const PlanarPose before = filter.pose();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  information(1, 1) = 1e4;
  filter.update({before.x() + 5.0, before.y() + 0.1, before.z()}, information);
  EXPECT_NEAR(filter.pose().x(), before.x(), 1e-3);
  EXPECT_GT(filter.pose().y(), before.y() + 0.05);
}

TEST(Consistency, CountsDegreesOfFreedomAndTheInsideOfTheRegion) {
  Consistency consistency;
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.04, 0.01, 1e-4).asDiagonal();
  consistency.add({0.2, 0.1, 0.01}, covariance, kAll);
  EXPECT_NEAR(consistency.per_freedom(), 1.0, 1e-12);
  const bool left_alone[3] = {false, true, false};
  consistency.add({50.0, 0.3, 1.0}, covariance, left_alone);
  EXPECT_NEAR(consistency.per_freedom(), 12.0 / 4.0, 1e-12);
  EXPECT_EQ(consistency.inside_percent(), 50.0);
}

LoopSummary summary_of(WorldLocalizer& localizer, const IntegrityWorld& world,
                       CovarianceSource source) {
  LoopOptions options;
  options.source = source;
  LoopSummaries summaries;
  add_loop(drive_closed_loop(localizer, world.drives[0], options), summaries);
  return summaries["streets"];
}

// Of covariances that are right it is 1. Errors of one short street are not independent.
TEST(Integrity, MatchesInAStreetAreAboutAsWrongAsTheirInformation) {
  IntegrityWorldOptions making;
  making.seed = 3;
  making.length_m = 60.0;
  const IntegrityWorld world = *make_integrity_world(making);
  WorldLocalizer localizer(world, Look{.range_m = 50.0});
  const LoopSummary found = summary_of(localizer, world, CovarianceSource::kStructure);
  EXPECT_GT(found.scans, 50u);
  EXPECT_EQ(found.lost, 0u);
  EXPECT_GT(found.match.per_freedom(), 0.3);
  EXPECT_LT(found.match.per_freedom(), 2.0);
  EXPECT_GT(found.match.inside_percent(), 85.0);
  const LoopSummary laplace = summary_of(localizer, world, CovarianceSource::kLaplace);
  EXPECT_GT(laplace.match.per_freedom(), 5.0);
}

}  // namespace
}  // namespace sightline
