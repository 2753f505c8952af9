#include "formats/drive/look_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include "passes/pass/default_looks.h"

namespace sightline {
namespace {

TEST(LookTest, WeighsEachSign) {
  LookTest test;
  test.constant = -1.0;
  EXPECT_DOUBLE_EQ(doubt_of(test, LookSigns{}), -1.0);
  LookSigns signs{};
  for (std::size_t i = 0; i < kLookSigns; ++i) {
    test.weights[i] = static_cast<double>(i) + 1.0;
    signs[i] = 0.5;
  }
  EXPECT_DOUBLE_EQ(doubt_of(test, signs), -1.0 + 18.0);
}

TEST(LookTest, NamesItsSigns) {
  const std::set<std::string_view> names(look_sign_names().begin(), look_sign_names().end());
  EXPECT_EQ(names.size(), kLookSigns);
  EXPECT_EQ(names.count(""), 0U);
}

TEST(LookPlan, BeginsWithTheLookOfAPlaceThatIsCheaper) {
  const LookPlan plan = usual_plan();
  const Look sparse = far_look(650, 30.0, 40, true);
  EXPECT_EQ(plan_at(plan, sparse).first.point_count, 40U);
  EXPECT_EQ(plan_at(plan, sparse).first.mode, LookMode::kSettle);
  EXPECT_EQ(plan_at(plan, sparse).second, plan.second);
  EXPECT_EQ(plan_at(plan, far_look(4000, 50.0, 128, true)), plan) << "dearer";
  EXPECT_EQ(plan_at(plan, far_look(4000, 50.0, 64, true)), plan) << "looks at more returns";
  EXPECT_EQ(plan_at(plan, far_look(400, 20.0, 0, false)), plan) << "matches all that is left";
  EXPECT_EQ(plan_at(plan, every_return(20.0)), plan) << "a range";
}

TEST(LookPlan, RefusesPlansThatMakeNoSense) {
  EXPECT_TRUE(validate(usual_plan()));
  const auto expect_refused = [](const auto& change) {
    LookPlan plan = usual_plan();
    change(plan);
    const Result<void> valid = validate(plan);
    ASSERT_FALSE(valid);
    EXPECT_EQ(valid.error().code, ErrorCode::kBadArgument);
  };
  expect_refused([](LookPlan& plan) { plan.first.range_m = -1.0; });
  expect_refused([](LookPlan& plan) { plan.second.return_count = 0; });
  expect_refused([](LookPlan& plan) { plan.doubt_above = std::nan(""); });
  expect_refused([](LookPlan& plan) { plan.limit_m = 0.0; });
  expect_refused([](LookPlan& plan) { plan.test.constant = std::nan(""); });
  expect_refused(
      [](LookPlan& plan) { plan.test.weights[3] = std::numeric_limits<double>::infinity(); });
}

}  // namespace
}  // namespace sightline
