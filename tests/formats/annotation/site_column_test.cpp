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

TEST(SiteColumn, HasNoValueButItsSteps) {
  SiteColumn column{"kind", "", {2.0F, 0.5F}, {0.5F, 1.0F, 2.0F}};
  EXPECT_TRUE(validate(column).has_value());
  expect_survives_disk(column);
  EXPECT_EQ(step_of(column, 2.0F), 2U);
  EXPECT_EQ(step_of(column, 3.0F), kMostColumnSteps);
  column.values[1] = 0.75F;
  EXPECT_EQ(failure_of(validate(column)).place, "site 1");
  column.values[1] = 0.5F;
  column.steps = {0.5F, 2.0F, 2.0F};
  EXPECT_FALSE(validate(column)) << "they do not ascend";
  column.steps.assign(257, 0.0F);
  for (std::size_t i = 0; i < 257; ++i) column.steps[i] = 0.5F * static_cast<float>(i);
  EXPECT_FALSE(validate(column)) << "a byte has 256 values";
}

}  // namespace
}  // namespace sightline
