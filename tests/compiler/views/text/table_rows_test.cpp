#include "compiler/views/text/table_rows.h"

#include <gtest/gtest.h>

#include "formats/annotation/factor_table.h"

namespace sightline {
namespace {

Table two_kinds() {
  FactorTable ranges;
  ranges.looks = every_return_at({10.0, 20.0});
  ranges.factors = {"feature_count"};
  ranges.site_count = 2;
  ranges.values = {1.0, 2.0, 3.0, 4.0};
  FactorTable samples = ranges;
  samples.looks = {{.range_m = 100.0, .return_count = 650, .point_count = 40}};
  samples.factors = {"feature_count", "match_cost"};
  samples.values = {5.0, 6.0, 7.0, 8.0};
  return dump(ByFamily<FactorTable>(ranges, samples));
}

TEST(KeepLooks, LeavesObservationRangesAsTheyStoodBeforeLooks) {
  Table table = two_kinds();
  keep_looks(KeptLooks::kRanges, table);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"site", "range_m", "feature_count"}));
  ASSERT_EQ(table.rows.size(), 4U);
  EXPECT_EQ(table.rows[3], (std::vector<Cell>{std::int64_t{1}, 20.0, 4.0}));
}

TEST(KeepLooks, LeavesLooksThatTakeASampleWithTheirName) {
  Table table = two_kinds();
  keep_looks(KeptLooks::kSamples, table);
  EXPECT_EQ(table.columns,
            (std::vector<std::string>{"site", "range_m", "look", "feature_count", "match_cost"}));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[1][2], Cell(std::string("100 m, 650 returns, 40 points")));
}

TEST(KeepLooks, RowsOfSamplesAreMovedAsTheyWouldBeKept) {
  Table table = two_kinds();
  Table kept = table;
  keep_looks(KeptLooks::kSamples, kept);
  const Table taken = take_samples(table);
  EXPECT_EQ(taken.name, kept.name);
  EXPECT_EQ(taken.columns, kept.columns);
  EXPECT_EQ(taken.rows, kept.rows);
  EXPECT_EQ(table.columns, two_kinds().columns);
  ASSERT_EQ(table.rows.size(), 4U);
  Table of_ranges = two_kinds();
  keep_looks(KeptLooks::kRanges, of_ranges);
  keep_looks(KeptLooks::kRanges, table);
  EXPECT_EQ(table.rows, of_ranges.rows);
}

TEST(KeepLooks, LeavesATableThatTellsOfNoLooks) {
  Table table;
  table.name = "sites";
  table.columns = {"site", "name"};
  table.rows = {{std::int64_t{0}, std::string()}};
  const Table before = table;
  keep_looks(KeptLooks::kRanges, table);
  EXPECT_EQ(table.columns, before.columns);
  EXPECT_EQ(table.rows, before.rows);
}

TEST(WorldColumns, ShiftPlacesByTheOriginOfTheFrame) {
  Table table{"evaluation-sites", {"site", "p_x_m", "p_y_m", "error_m"}, {}, {}};
  table.rows = {{std::int64_t{0}, 1.5, -2.0, 0.1}};
  append_world_columns({{640.0, -64.0, 0.0}}, table);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"site", "p_x_m", "p_y_m", "error_m",
                                                     "p_x_world_m", "p_y_world_m"}));
  EXPECT_EQ(table.rows[0], (std::vector<Cell>{std::int64_t{0}, 1.5, -2.0, 0.1, 641.5, -66.0}));
  Table without{"evaluation", {"rule"}, {{std::string("map")}}, {}};
  append_world_columns({{640.0, -64.0, 0.0}}, without);
  EXPECT_EQ(without.columns, std::vector<std::string>{"rule"});
}

}  // namespace
}  // namespace sightline
