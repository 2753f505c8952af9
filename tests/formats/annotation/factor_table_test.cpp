#include "formats/annotation/factor_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

FactorTable small_table() {
  FactorTable table;
  table.looks = every_return_at({10.0, 20.0});
  table.factors = {"feature_count", "r_average"};
  table.site_count = 2;
  table.values = {1, 9.5, 2, 14.5, 0, 10, 3, 12.25};
  return table;
}

TEST(FactorTable, SurvivesDisk) { expect_survives_disk(small_table()); }

TEST(FactorTable, DumpsOneRowForEachSiteAndRange) {
  const Table text = dump(small_table());
  EXPECT_EQ(text.columns,
            (std::vector<std::string>{"site", "range_m", "look", "feature_count", "r_average"}));
  ASSERT_EQ(text.rows.size(), 4U);
  EXPECT_EQ(text.rows[3],
            (std::vector<Cell>{std::int64_t{1}, 20.0, std::string("20 m"), 3.0, 12.25}));
}

TEST(FactorTable, RefusesRangesThatDoNotAscend) {
  FactorTable table = small_table();
  table.looks = every_return_at({20.0, 20.0});
  EXPECT_FALSE(validate(table).has_value());
}

TEST(FactorTable, RefusesTwoFactorsOfOneName) {
  FactorTable table = small_table();
  table.factors[1] = table.factors[0];
  EXPECT_FALSE(validate(table).has_value());
}

TEST(FactorTable, NamesTheFactorAndSiteThatAreNotFinite) {
  FactorTable table = small_table();
  table.values[5] = std::nan("");
  const Result<void> valid = validate(table);
  ASSERT_FALSE(valid.has_value());
  EXPECT_EQ(valid.error().message, "r_average is not finite");
  EXPECT_EQ(valid.error().place, "site 1");
}

TEST(FactorTable, RefusesTooFewValues) {
  FactorTable table = small_table();
  table.values.pop_back();
  EXPECT_FALSE(validate(table).has_value());
}

}  // namespace
}  // namespace sightline
