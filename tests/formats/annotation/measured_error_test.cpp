#include "formats/annotation/measured_error.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

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

TEST(MeasuredError, RefusesWhatIsNoMeasurement) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  expect_refused<MeasuredError>(
      two_sites(), {[](MeasuredError& fewer) { fewer.rows.pop_back(); },
                    [](MeasuredError& negative) { negative.rows[0].p90_m = -0.1; },
                    [](MeasuredError& infinite) { infinite.rows[0].p90_m = kInfinity; },
                    [](MeasuredError& without_scan) { without_scan.rows[3].mean_m = 0.1; },
                    [](MeasuredError& descending) {
                      descending.looks = every_return_at({20.0, 20.0});
                    }});
}

}  // namespace
}  // namespace sightline
