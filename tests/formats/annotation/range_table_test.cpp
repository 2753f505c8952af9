#include "formats/annotation/range_table.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

RangeTable two_sites() {
  RangeTable table;
  table.looks = every_return_at({10.0, 15.0, 20.0});
  table.dilation_m = 3.0;
  constexpr PromiseScope kNext = PromiseScope::kNextDrive;
  table.promises = {
      {0.1, "conformal", 0.8, 0.7, 0.05, 0.0, 20, 4, 8, kNext, true, 0.04, 0.9, "kept"},
      {0.25, "conformal", 0.7, 0.6, 0.05, 0.0, 20, 4, 8, kNext, false, 0.06, 0.8, "not"}};
  table.site_count = 2;
  table.range_index = {2, 1, 1, 0};
  table.flags = {kUnmet, 0, kExtrapolated, kStatic};
  table.reasons = {Reason::kMostProbable, Reason::kModel, Reason::kModel, Reason::kCheaper};
  return table;
}

ErrorCode code_of(const RangeTable& table) {
  const Result<void> valid = validate(table);
  return valid ? ErrorCode{} : valid.error().code;
}

TEST(RangeTable, SurvivesTheDisk) { expect_survives_disk(two_sites()); }

TEST(RangeTable, KeepsThePlanOfItsLooks) {
  RangeTable looks = two_sites();
  looks.looks = {{.range_m = 60.0, .return_count = 300, .point_count = 60},
                 {.range_m = 60.0, .return_count = 800, .point_count = 150},
                 {.range_m = 60.0, .return_count = 900, .point_count = 160}};
  looks.plan = LookPlan{};
  looks.plan->first = looks.looks[0];
  looks.plan->second = looks.looks[2];
  looks.plan->test.weights[3] = -1.5;
  looks.plan->doubt_above = std::numeric_limits<double>::infinity();
  const ByFamily<RangeTable> both(two_sites(), looks);
  ASSERT_TRUE(validate(both)) << to_string(validate(both).error());
  expect_survives_disk(both);
  looks.plan->test.constant = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code_of(looks), ErrorCode::kInvalidArtifact);
  RangeTable of_ranges = two_sites();
  of_ranges.plan = LookPlan{};
  EXPECT_EQ(code_of(of_ranges), ErrorCode::kInvalidArtifact) << "a plan is of samples";
}

TEST(RangeTable, IsPrintedPerSiteAndLimit) {
  const Table table = dump(two_sites());
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.rows[0],
            (std::vector<Cell>{std::int64_t{0}, 0.1, 20.0, std::string("20 m"), std::int64_t{1},
                               std::int64_t{0}, std::int64_t{0}, std::string("most-probable")}));
  EXPECT_EQ(table.rows[2],
            (std::vector<Cell>{std::int64_t{1}, 0.1, 15.0, std::string("15 m"), std::int64_t{0},
                               std::int64_t{1}, std::int64_t{0}, std::string("model")}));
  EXPECT_EQ(table.rows[3].end()[-2], Cell{std::int64_t{1}}) << "static";
  EXPECT_EQ(table.rows[3].back(), Cell{std::string("cheaper")});
}

TEST(RangeTable, RefusesALooserLimitThatLooksFurther) {
  RangeTable table = two_sites();
  table.range_index[3] = 2;
  EXPECT_EQ(code_of(table), ErrorCode::kInvalidArtifact);
}

TEST(RangeTable, RefusesAPromiseThatIsNotAboutTheNextDrive) {
  RangeTable table = two_sites();
  table.promises[1].scope = PromiseScope::kThisDrive;
  EXPECT_TRUE(validate(table).has_value()) << "it promises nothing";
  table.promises[0].scope = PromiseScope::kThisDrive;
  EXPECT_EQ(code_of(table), ErrorCode::kInvalidArtifact);
}

TEST(RangeTable, RefusesWhatLiesOutOfBounds) {
  RangeTable no_range = two_sites();
  no_range.range_index[0] = 3;
  EXPECT_EQ(code_of(no_range), ErrorCode::kInvalidArtifact);
  RangeTable no_flag = two_sites();
  no_flag.flags[1] = 4;
  EXPECT_EQ(code_of(no_flag), ErrorCode::kInvalidArtifact);
  for (const int unknown : {0, 12}) {
    RangeTable no_reason = two_sites();
    no_reason.reasons[2] = static_cast<Reason>(unknown);
    EXPECT_EQ(code_of(no_reason), ErrorCode::kInvalidArtifact) << unknown;
  }
  RangeTable no_share = two_sites();
  no_share.promises[0].alpha = 1.5;
  EXPECT_EQ(code_of(no_share), ErrorCode::kInvalidArtifact);
  RangeTable no_answers = two_sites();
  no_answers.promises[0].answered_share = -0.1;
  EXPECT_EQ(code_of(no_answers), ErrorCode::kInvalidArtifact);
  RangeTable descending = two_sites();
  descending.promises[1].limit_m = 0.05;
  EXPECT_EQ(code_of(descending), ErrorCode::kInvalidArtifact);
  RangeTable fewer = two_sites();
  fewer.flags.pop_back();
  EXPECT_EQ(code_of(fewer), ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
