#include "formats/evaluation/evaluation.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

Evaluation small_evaluation() {
  Evaluation evaluation;
  evaluation.drive = "second";
  evaluation.site_count = 3;
  evaluation.out_of_fold_count = 1;
  evaluation.stretch_m = 100.0;
  evaluation.limits_m = {0.1};
  evaluation.statics = {{10.0, 0.2, 3.0, 4.0, 5.0, 600.0, 0.5, 0.1}};
  for (std::size_t i = 0; i < kRuleCount; ++i) {
    RuleScore score;
    score.limit_m = 0.1;
    score.rule = static_cast<Rule>(i);
    score.coverage = 0.5;
    evaluation.rules.push_back(score);
  }
  evaluation.reliability = {{0.1, 0.85, 0.8, 2}};
  evaluation.sites = {{0, 0, 0.0, 1.0, 2.0, PlaceKind::kLane}, {2, 0, 2.0, 3.0, 2.0}};
  evaluation.kinds = {{Rule::kMap, PlaceKind::kLane, 1, 0.1, 0.5, 1.0, 0.1, 0.1, 10.0, 1.0, 1.0}};
  evaluation.error_m = {0.1, 0.3};
  evaluation.time_ms = {3.0, 3.0};
  evaluation.chosen_range_index.assign(2 * kRuleCount, 0);
  return evaluation;
}

TEST(Evaluation, SurvivesTheDisk) { expect_survives_disk(small_evaluation()); }

TEST(Evaluation, PrintsEveryTableWithAsManyCellsAsColumns) {
  const std::vector<Table> all = tables(small_evaluation());
  ASSERT_EQ(all.size(), 6u);
  for (const Table& table : all) {
    EXPECT_FALSE(table.rows.empty()) << table.name;
    for (const std::vector<Cell>& row : table.rows) {
      EXPECT_EQ(row.size(), table.columns.size()) << table.name;
    }
  }
}

TEST(Evaluation, IsReadableForPeople) {
  const std::string text = to_text(small_evaluation(), {{64.0, -128.0, 0.0}});
  EXPECT_NE(text.find("2 of 3 sites evaluated against known poses"), std::string::npos) << text;
  EXPECT_NE(text.find("Table II."), std::string::npos);
  EXPECT_NE(text.find("static-equal-coverage        50.0"), std::string::npos) << text;
  EXPECT_NE(text.find("0 to 0, (65, -126) to (65, -126)"), std::string::npos) << text;
  EXPECT_NE(text.find("100.0 (10.0 m, 10.0 cm)"), std::string::npos) << text;
  EXPECT_NE(text.find("observed %  80.0"), std::string::npos) << text;
}

TEST(Evaluation, RefusesWhatIsOutOfPlaceOrMakesNoSense) {
  expect_refused<Evaluation>(
      small_evaluation(),
      {[](Evaluation& swapped) { std::swap(swapped.rules[0], swapped.rules[1]); },
       [](Evaluation& above_one) { above_one.rules[2].coverage = 1.5; },
       [](Evaluation& no_number) {
         no_number.statics[0].rmse_m = std::numeric_limits<double>::quiet_NaN();
       },
       [](Evaluation& backwards) { backwards.rules[1].worst_begin_site = 2; },
       [](Evaluation& unknown) { unknown.kinds[0].kind = PlaceKind::kUnknown; },
       [](Evaluation& no_site) { no_site.sites[1].site = 3; },
       [](Evaluation& no_range) { no_range.chosen_range_index[3] = 1; },
       [](Evaluation& fewer) { fewer.error_m.pop_back(); }});
}

}  // namespace
}  // namespace sightline
