#include "formats/annotation/measured_error.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

MeasuredError two_sites() {
  MeasuredError measured;
  measured.drive = "morning";
  measured.reference = ErrorReference::kFullRangeMatch;
  measured.looks = every_return_at({10.0, 20.0});
  measured.offsets = {{0.25, 0.5, -0.1, 0.01}};
  measured.scan_of_site = {7, -1};
  measured.rows.resize(4);
  measured.rows[0].mean_m = 0.5;
  measured.rows[0].point_count = 123;
  measured.rows[0].lost_share = 1.0;
  measured.rows[1].max_time_ms = 2.5;
  return measured;
}

TEST(MeasuredError, SurvivesDisk) { expect_survives_disk(two_sites()); }

TEST(MeasuredError, DumpsARowForEachSiteAndRange) {
  const Table table = dump(two_sites());
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.columns[5], "mean_m");
  EXPECT_EQ(table.columns.size(), table.rows[0].size());
  EXPECT_EQ(std::get<double>(table.rows[0][5]), 0.5);
  EXPECT_EQ(std::get<std::int64_t>(table.rows[2][3]), -1);
}

void expect_refused(const MeasuredError& measured) {
  EXPECT_EQ(failure_of(validate(measured)).code, ErrorCode::kInvalidArtifact);
}

TEST(MeasuredError, RefusesANumberOfRowsThatDoesNotFit) {
  MeasuredError measured = two_sites();
  measured.rows.pop_back();
  expect_refused(measured);
}

TEST(MeasuredError, RefusesNegativeAndInfiniteErrors) {
  MeasuredError measured = two_sites();
  measured.rows[0].p90_m = -0.1;
  expect_refused(measured);
  measured.rows[0].p90_m = std::numeric_limits<double>::infinity();
  expect_refused(measured);
}

TEST(MeasuredError, RefusesAResultWithoutAScan) {
  MeasuredError measured = two_sites();
  measured.rows[3].mean_m = 0.1;
  expect_refused(measured);
}

TEST(MeasuredError, RefusesRangesThatDoNotAscend) {
  MeasuredError measured = two_sites();
  measured.looks = every_return_at({20.0, 20.0});
  expect_refused(measured);
}

}  // namespace
}  // namespace sightline
