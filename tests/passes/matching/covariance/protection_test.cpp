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
  const auto add = [&](Integrity match) { return monitor.add(match, {}, kRow); };
  EXPECT_EQ(add(Integrity::kDoubtful), Integrity::kOk);
  EXPECT_EQ(add(Integrity::kOk), Integrity::kOk);
  for (int i = 0; i < 20; ++i) add(Integrity::kDoubtful);
  EXPECT_EQ(add(Integrity::kOk), Integrity::kLost);
  EXPECT_EQ(add(Integrity::kOk), Integrity::kLost);
  EXPECT_EQ(add(Integrity::kOk), Integrity::kDoubtful);
  EXPECT_EQ(add(Integrity::kOk), Integrity::kDoubtful);
  EXPECT_EQ(add(Integrity::kOk), Integrity::kOk);
  EXPECT_EQ(IntegrityMonitor{}.add(Integrity::kUnknown, {}, kRow), Integrity::kUnknown);
}

TEST(IntegrityMonitor, DoubtsPosesWhereTheMapLacksRaisedPointsOfSuccessiveScans) {
  ProtectionRow row = kRow;
  row.least_raised_share = 0.5;
  IntegrityMonitor monitor;
  EXPECT_EQ(monitor.add(Integrity::kOk, {8, 0}, row), Integrity::kOk) << "8 of 16";
  EXPECT_EQ(monitor.add(Integrity::kOk, {1, 0}, row), Integrity::kDoubtful) << "8 of 16.2";
  EXPECT_EQ(monitor.add(Integrity::kOk, {40, 40}, row), Integrity::kOk);
  for (int i = 0; i < 10; ++i) monitor.add(Integrity::kOk, {20, 5}, row);
  EXPECT_EQ(monitor.add(Integrity::kOk, {20, 5}, row), Integrity::kDoubtful);
  for (int i = 0; i < 100; ++i) monitor.add(Integrity::kOk, {}, row);
  EXPECT_EQ(monitor.add(Integrity::kOk, {}, row), Integrity::kOk) << "old scans are forgotten";
  row.least_raised_share = 0.0;
  EXPECT_EQ(monitor.add(Integrity::kOk, {1000, 0}, row), Integrity::kOk) << "no bound";
}

}  // namespace
}  // namespace sightline
