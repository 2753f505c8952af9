#include "formats/annotation/measured_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string_view>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

MeasuredError two_sites() {
  MeasuredError measured;
  measured.drive = "morning";
  measured.reference = ErrorReference::kFullRangeMatch;
  measured.looks = every_return_at({10.0, 20.0});
  measured.offsets = {{0.25, 0.5, -0.1, 0.01}};
  measured.tracking_offsets = {{0.2, 0.0, 0.0, 0.01}, {-0.2, 0.0, 0.0, -0.01}};
  measured.tracking_ends.resize(8);
  measured.tracking_ends[0] = {0.25F, 0.0F, -0.5F, 0.0F};
  measured.tracking_ends[1] = {0.05F, 0.0F, -0.5F, 0.0F};
  measured.scan_of_site = {7, -1};
  measured.rows.resize(4);
  measured.rows[0].mean_m = 0.5;
  measured.rows[0].point_count = 123;
  measured.rows[0].lost_share = 1.0;
  measured.rows[0].max_m = 0.5;
  measured.rows[0].lateral_m = 0.25;
  measured.rows[0].directions.mean.lateral_m = -0.25F;
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

TEST(MeasuredError, DumpsErrorsByDirectionOfBothKindsOfStart) {
  const Table table = dump(two_sites());
  const auto cell = [&](std::string_view name) -> double {
    const auto column = std::ranges::find(table.columns, name);
    if (column == table.columns.end()) return -1.0;
    return std::get<double>(
        table.rows[0][static_cast<std::size_t>(column - table.columns.begin())]);
  };
  EXPECT_EQ(cell("mean_lateral_m"), -0.25);
  EXPECT_NEAR(cell("tracking_mean_longitudinal_m"), 0.15, 1e-7);
  EXPECT_NEAR(cell("tracking_deviation_longitudinal_m"), 0.1, 1e-7);
  EXPECT_NEAR(cell("tracking_kept_longitudinal_m"), 0.5, 1e-7);
  EXPECT_EQ(cell("tracking_mean_height_m"), -0.5);
}

TEST(MeasuredError, RefusesWhatIsNoMeasurement) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  expect_refused<MeasuredError>(
      two_sites(),
      {[](MeasuredError& fewer) { fewer.rows.pop_back(); },
       [](MeasuredError& negative) { negative.rows[0].p90_m = -0.1; },
       [](MeasuredError& infinite) { infinite.rows[0].p90_m = kInfinity; },
       [](MeasuredError& without_scan) { without_scan.rows[3].mean_m = 0.1; },
       [](MeasuredError& fewer) { fewer.tracking_ends.pop_back(); },
       [](MeasuredError& more) { more.tracking_offsets.emplace_back(); },
       [](MeasuredError& infinite) {
         infinite.tracking_ends[1].yaw_rad = std::numeric_limits<float>::infinity();
       },
       [](MeasuredError& without_scan) { without_scan.tracking_ends[7].height_m = 0.1F; },
       [](MeasuredError& other) { other.rows[0].directions.mean.lateral_m = 0.26F; },
       [](MeasuredError& wide) { wide.rows[0].directions.deviation.height_m = 0.6F; },
       [](MeasuredError& negative) { negative.rows[0].directions.deviation.yaw_rad = -0.1F; },
       [](MeasuredError& descending) {
         descending.looks = every_return_at({20.0, 20.0});
       }});
}

}  // namespace
}  // namespace sightline
