#include "formats/drive/look.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string_view>

#include "formats/base/random.h"
#include "formats/record/codec.h"
#include "passes/pass/default_looks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

TEST(Look, IsOneLineOfText) {
  EXPECT_EQ(to_text(every_return(50.0)), "50 m");
  EXPECT_EQ(to_text(Look{.range_m = 42.5, .return_count = 2000}), "42.5 m, 2000 returns");
  const Look look{.range_m = 50.0,
                  .return_count = 2000,
                  .even_beyond_m = 30.0,
                  .point_count = 80,
                  .is_by_normals = true,
                  .mode = LookMode::kSettle};
  EXPECT_EQ(to_text(look),
            "50 m, 2000 returns, evenly spaced beyond 30 m, 80 points by normals, settle");
}

TEST(Look, ReadsWhatItWrites) {
  Random random(5);
  for (int trial = 0; trial < 500; ++trial) {
    Look look = every_return(random.uniform(0.1, 999.0));
    if (random.below(4) > 0) {
      look.return_count = static_cast<std::uint32_t>(1 + random.below(100000));
      if (random.below(2) > 0) look.even_beyond_m = random.uniform(0.1, 999.0);
      if (random.below(2) > 0) {
        look.point_count = static_cast<std::uint32_t>(1 + random.below(5000));
        look.is_by_normals = random.below(2) > 0;
      }
    }
    if (random.below(2) > 0) look.mode = LookMode::kSettle;
    EXPECT_EQ(value_of(parse_look(to_text(look))), look) << to_text(look);
  }
}

TEST(Look, ReadsTheWordsOfEarlierVersions) {
  const Look look = value_of(parse_look("50 m, 2000 returns, even beyond 30 m"));
  EXPECT_EQ(to_text(look), "50 m, 2000 returns, evenly spaced beyond 30 m");
}

TEST(Look, ForgivesBlanksAroundCommas) {
  const Look look = value_of(parse_look("50 m,2000 returns ,  100 points"));
  EXPECT_EQ(to_text(look), "50 m, 2000 returns, 100 points");
}

TEST(Look, RefusesWhatMakesNoSense) {
  const auto expect_refused = [](const std::string& text) {
    const Error error = failure_of(parse_look(text), text);
    EXPECT_EQ(error.code, ErrorCode::kBadArgument);
    EXPECT_NE(error.message.find("expected a look like"), std::string::npos);
  };
  for (const char* text :
       {"", "50", "m", "-3 m", "0 m", "1000 m", "nan m", "inf m", "50 m,", "50m", "50 m settle"}) {
    expect_refused(text);
  }
  for (const char* part : {"", "2000", "-1 returns", "1.5 returns", "9999999999 returns",
                           "80 points", "evenly spaced beyond 30 m", "settle, settle",
                           "settle, 2000 returns", "80 points, 2000 returns"}) {
    expect_refused(std::string("50 m, ") + part);
  }
  for (const char* part : {"evenly spaced beyond 0.5 km", "even beyond -1 m", "by normals",
                           "points by normals", "2000 returns", "0 points by normals"}) {
    expect_refused(std::string("50 m, 2000 returns, ") + part);
  }
}

std::vector<Look> some_looks() {
  return {every_return(10.0), every_return(50.0),
          Look{.range_m = 100.0, .return_count = 650, .point_count = 40},
          Look{.range_m = 80.0,
               .return_count = 1944,
               .even_beyond_m = 30.0,
               .point_count = 80,
               .is_by_normals = true,
               .mode = LookMode::kSettle}};
}

TEST(Looks, AreReadAsTheyAreWritten) {
  EXPECT_EQ(value_of(parse_looks(to_text(some_looks()))), some_looks());
}

TEST(Looks, AreReadFromAListInYaml) {
  const std::vector<Look> looks =
      value_of(parse_looks("[100 m, 650 returns, 40 points, 80 m, 900 returns]"));
  ASSERT_EQ(looks.size(), 2U);
  EXPECT_EQ(to_text(looks.back()), "80 m, 900 returns");
}

TEST(Looks, AreRefusedWhereOneStandsTwiceOrThereIsNone) {
  EXPECT_FALSE(parse_looks(""));
  EXPECT_FALSE(parse_looks("50 m; 50 m"));
  EXPECT_FALSE(parse_looks("650 returns; 50 m"));
}

TEST(Looks, OrderATableByAscendingRangesAndNameEachOnce) {
  EXPECT_TRUE(validate(some_looks()));
  EXPECT_FALSE(validate(std::vector<Look>{}));
  std::vector<Look> descending = some_looks();
  std::swap(descending[0], descending[1]);
  EXPECT_FALSE(validate(descending));
  std::vector<Look> twice = some_looks();
  twice.push_back(twice[2]);
  EXPECT_FALSE(validate(twice));
}

TEST(Looks, AreEncodedAndBackAndRefusedWithAnUnknownMode) {
  ByteWriter writer;
  encode(some_looks(), writer);
  std::vector<std::byte> bytes = writer.take();
  std::vector<Look> again;
  ByteReader reader(bytes);
  decode(reader, again);
  EXPECT_TRUE(reader.at_end());
  EXPECT_EQ(again, some_looks());
  bytes.back() = std::byte{2};
  ByteReader damaged(bytes);
  decode(damaged, again);
  EXPECT_FALSE(damaged.ok());
}

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
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(validate(usual_plan()));
  for (const auto& change : std::vector<std::function<void(LookPlan&)>>{
           [](LookPlan& plan) { plan.first.range_m = -1.0; },
           [](LookPlan& plan) { plan.second.return_count = 0; },
           [](LookPlan& plan) { plan.doubt_above = std::nan(""); },
           [](LookPlan& plan) { plan.limit_m = 0.0; },
           [](LookPlan& plan) { plan.test.constant = std::nan(""); },
           [](LookPlan& plan) { plan.test.weights[3] = kInfinity; }}) {
    LookPlan plan = usual_plan();
    change(plan);
    EXPECT_EQ(code_of(validate(plan)), ErrorCode::kBadArgument);
  }
}

}  // namespace
}  // namespace sightline
