#include "passes/matching/covariance/protection.h"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

namespace sightline {
namespace {

constexpr ProtectionRow kRow = {.place = "test",
                                .block_count = 99,
                                .covariance_factor = 1.0,
                                .percent_factors = {4.0, 5.0, 6.0, 7.0},
                                .percent_errors = {1.0, 1.0, 1.0, 1.0},
                                .least_likelihood = 2.0,
                                .least_scored_share = 0.9};

TEST(ProtectionLevels, AreFactorsOfTheStandardDeviationsInTheVehiclesAxes) {
  PoseEstimate estimate;
  Vector6d variances;
  variances << 0.01, 0.04, 0.09, 1e-6, 1e-6, 1e-4;
  estimate.covariance = variances.asDiagonal();
  // The vehicle looks along map y.
  estimate.T_map_vehicle.linear() =
      Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const ProtectionFactors levels = protection_levels(estimate, kRow, 0.01);
  EXPECT_NEAR(levels[0], 4.0 * 0.2, 1e-12);
  EXPECT_NEAR(levels[1], 5.0 * 0.1, 1e-12);
  EXPECT_NEAR(levels[2], 6.0 * 0.3, 1e-12);
  EXPECT_NEAR(levels[3], 7.0 * 0.01, 1e-12);
}

TEST(ProtectionLevels, ForARiskThatTooFewBlocksCalibratedAreUnavailable) {
  for (const double level : protection_levels({}, kRow, 0.001)) EXPECT_EQ(level, kUnavailable);
  for (const double level : protection_levels({}, {}, 0.01)) EXPECT_EQ(level, kUnavailable);
}

TEST(ProtectionTable, GivesNoFactorOfFewerThanNinetyNineBlocks) {
  for (unsigned kind = 0; kind < 300; ++kind) {
    const ProtectionRow& row = protection_row(group_of_kind(kind));
    EXPECT_GT(row.covariance_factor, 0.0);
    for (const double factor : row.percent_factors) {
      EXPECT_TRUE(row.block_count >= 99 ? factor > 0.0 : factor == kUnavailable) << row.place;
    }
  }
}

MatchResult match_of(double likelihood, std::uint32_t scored_points) {
  MatchResult match;
  match.nearest_voxel_likelihood = likelihood;
  match.scored_points = scored_points;
  return match;
}

TEST(IntegrityOfMatch, IsDoubtfulWhereEitherSignIsBelowTheGoodOnes) {
  EXPECT_EQ(integrity_of(match_of(2.5, 95), 100, kRow), Integrity::kOk);
  EXPECT_EQ(integrity_of(match_of(1.9, 95), 100, kRow), Integrity::kDoubtful);
  EXPECT_EQ(integrity_of(match_of(2.5, 89), 100, kRow), Integrity::kDoubtful);
  EXPECT_EQ(integrity_of(match_of(0.0, 0), 100, kRow), Integrity::kUnknown);
}

TEST(IntegrityMonitor, NeedsSeveralDoubtfulMatchesAndRecovers) {
  IntegrityMonitor monitor;
  EXPECT_EQ(monitor.add(Integrity::kDoubtful), Integrity::kOk);
  EXPECT_EQ(monitor.add(Integrity::kOk), Integrity::kOk);
  for (int i = 0; i < 20; ++i) monitor.add(Integrity::kDoubtful);
  EXPECT_EQ(monitor.add(Integrity::kOk), Integrity::kLost);
  EXPECT_EQ(monitor.add(Integrity::kOk), Integrity::kLost);
  EXPECT_EQ(monitor.add(Integrity::kOk), Integrity::kDoubtful);
  EXPECT_EQ(monitor.add(Integrity::kOk), Integrity::kDoubtful);
  EXPECT_EQ(monitor.add(Integrity::kOk), Integrity::kOk);
  EXPECT_EQ(IntegrityMonitor{}.add(Integrity::kUnknown), Integrity::kUnknown);
}

}  // namespace
}  // namespace sightline
