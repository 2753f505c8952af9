#include "formats/annotation/site_column.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

TEST(SiteColumn, SurvivesDisk) {
  expect_survives_disk(
      SiteColumn{"clearance_m", {3.0, std::numeric_limits<double>::infinity(), 0.25}});
}

TEST(SiteColumn, IsPrintedByItsName) {
  EXPECT_EQ(format_table(dump(SiteColumn{"clearance_m", {3.0, 0.25}}), TableFormat::kCsv),
            "site,clearance_m\n0,3\n1,0.25\n");
}

TEST(SiteColumn, RefusesWhatIsNoNumberAndNamesTheSite) {
  const Result<void> valid =
      validate(SiteColumn{"clearance_m", {1.0, std::numeric_limits<double>::quiet_NaN()}});
  ASSERT_FALSE(valid);
  EXPECT_EQ(valid.error().place, "site 1");
  EXPECT_FALSE(validate(SiteColumn{"", {1.0}}));
}

}  // namespace
}  // namespace sightline
