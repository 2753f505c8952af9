#include "compiler/views/text/factor_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/synthetic_drive.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

// Four sites at one range: "good" falls as the error rises, "level" never differs.
struct FourSites {
  FactorTable factors;
  MeasuredError measured;
};

FourSites four_sites() {
  FourSites four;
  four.factors.looks = four.measured.looks = every_return_at({10.0});
  four.factors.factors = {"good", "level", "virtual_points"};
  four.factors.site_count = 4;
  four.factors.values = {9.0, 1.0, 100.0, 4.0, 1.0, 200.0, 1.0, 1.0, 300.0, 7.0, 1.0, 400.0};
  four.measured.scan_of_site = {0, 1, 2, 3};
  const double error_m[] = {0.1, 0.3, 0.9, 0.2};
  for (int i = 0; i < 4; ++i) {
    ErrorRow row;
    row.mean_m = error_m[i];
    row.point_count = static_cast<std::uint32_t>(90 * (i + 1));
    row.mean_time_ms = 0.5 + 0.01 * 100.0 * (i + 1);
    row.mean_work = 7.0 * row.point_count;
    four.measured.rows.push_back(row);
  }
  return four;
}

TEST(FactorReport, CorrelatesRanksAndExpectsTimeFromVirtualPoints) {
  const FourSites four = four_sites();
  const FactorReport report = value_of(factor_report(four.factors, four.measured));
  ASSERT_EQ(report.ranges.size(), 1U);
  const FactorsAtRange& at = report.ranges[0];
  // Ranks of errors are 0 2 3 1; those of "good" 3 1 0 2.
  EXPECT_NEAR(at.rank_correlation[0], -1.0, 1e-12);
  EXPECT_EQ(at.rank_correlation[1], 0.0);
  // Virtual points have ranks 0 1 2 3: 1 - 6 (0 + 1 + 1 + 4) / (4 (16 - 1)).
  EXPECT_NEAR(at.rank_correlation[2], 0.4, 1e-12);
  EXPECT_NEAR(at.virtual_points, 250.0, 1e-12);
  EXPECT_NEAR(at.measured_points, 225.0, 1e-12);
  EXPECT_NEAR(at.point_correlation, 1.0, 1e-12);
  EXPECT_NEAR(at.expected_time_ms, 3.0, 1e-12);
  EXPECT_NEAR(at.expected_work, at.measured_work, 1e-9);
}

TEST(FactorReport, LetsEqualValuesShareTheirRank) {
  FourSites four = four_sites();
  for (const std::size_t site : {0U, 3U}) four.factors.values[3 * site] = 8.0;
  const Result<FactorReport> report = factor_report(four.factors, four.measured);
  // Ranks 2.5 1 0 2.5 against 0 2 3 1.
  EXPECT_NEAR(report->ranges[0].rank_correlation[0], -4.5 / std::sqrt(4.5 * 5.0), 1e-12);
}

TEST(FactorReport, LeavesOutSitesWithoutAScan) {
  FourSites four = four_sites();
  four.measured.scan_of_site[2] = -1;
  four.measured.rows[2] = {};
  const Result<FactorReport> report = factor_report(four.factors, four.measured);
  EXPECT_NEAR(report->ranges[0].virtual_points, 700.0 / 3.0, 1e-9);
}

TEST(FactorReport, StaysWithinBoundsAndPrintsEveryFactorAtEveryRange) {
  SyntheticDrive drive = synthetic_drive(1, {.site_count = 200});
  drive.factors.factors.back() = "virtual_points";
  const FactorReport report = value_of(factor_report(drive.factors, drive.measured));
  for (const FactorsAtRange& range : report.ranges) {
    for (const double r : range.rank_correlation) {
      EXPECT_GE(r, -1.0 - 1e-12);
      EXPECT_LE(r, 1.0 + 1e-12);
    }
  }
  EXPECT_EQ(tables(report)[0].rows.size(), 9U * drive.factors.factors.size());
  EXPECT_EQ(tables(report)[1].rows.size(), 9U);
  for (const std::string& factor : drive.factors.factors) {
    EXPECT_THAT(to_text(report), testing::HasSubstr("\n" + factor + " "));
  }
}

TEST(FactorReport, RefusesWhatDoesNotBelongTogether) {
  FourSites other_ranges = four_sites();
  other_ranges.measured.looks = every_return_at({20.0});
  EXPECT_EQ(factor_report(other_ranges.factors, other_ranges.measured).error().code,
            ErrorCode::kMismatchedInputs);
  FourSites no_points = four_sites();
  no_points.factors.factors[2] = "other";
  EXPECT_EQ(factor_report(no_points.factors, no_points.measured).error().code,
            ErrorCode::kMismatchedInputs);
  FourSites unmeasured = four_sites();
  unmeasured.measured.scan_of_site.assign(4, -1);
  EXPECT_EQ(factor_report(unmeasured.factors, unmeasured.measured).error().code,
            ErrorCode::kNoOverlap);
}

}  // namespace
}  // namespace sightline
