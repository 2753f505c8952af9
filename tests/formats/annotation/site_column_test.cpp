#include "formats/annotation/site_column.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

TEST(SiteColumn, SurvivesDisk) {
  expect_survives_disk(
      SiteColumn{"clearance_m", "m", {3.0F, std::numeric_limits<float>::infinity(), 0.25F}});
}

TEST(SiteColumn, IsPrintedByItsName) {
  EXPECT_EQ(format_table(dump(SiteColumn{"clearance_m", "m", {3.0F, 0.25F}}), TableFormat::kCsv),
            "site,clearance_m\n0,3\n1,0.25\n");
}

TEST(SiteColumn, RefusesWhatIsNoNumberAndNamesTheSite) {
  EXPECT_EQ(failure_of(validate(SiteColumn{
                           "clearance_m", "m", {1.0F, std::numeric_limits<float>::quiet_NaN()}}))
                .place,
            "site 1");
  for (const char* name : {"", "Clearance", "clear ance", "a.b"}) {
    EXPECT_FALSE(validate(SiteColumn{name, "m", {1.0F}})) << name;
  }
  EXPECT_FALSE(validate(SiteColumn{"clearance_m", "m\n", {1.0F}}));
  EXPECT_TRUE(validate(SiteColumn{"share", "", {1.0F}}));
}

}  // namespace
}  // namespace sightline
