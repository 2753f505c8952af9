#include "passes/pass/options.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

struct Values {
  bool enabled = true;
  int count = 3;
  double cell_m = 2.0;
  std::string rule = "mean";
  std::string title;
  std::vector<double> ranges_m = {10.0, 15.0};
  std::vector<Look> looks = {{.range_m = 100.0, .return_count = 400, .point_count = 32}};
};

std::vector<OptionField> fields_of(Values& values) {
  return {flag("enabled", values.enabled, ""),
          integer("count", values.count, "", 1, 10),
          number("cell_m", values.cell_m, "", 0.1, 100.0),
          choice("rule", values.rule, "", {"mean", "probability"}),
          text("title", values.title, ""),
          numbers("ranges_m", values.ranges_m, "", 1.0, 200.0),
          looks("looks", values.looks, "")};
}

TEST(Options, AreSetFromTextAsItStandsInAFile) {
  Values values;
  std::vector<OptionField> fields = fields_of(values);
  EXPECT_TRUE(set_from_text(fields[0], "false"));
  EXPECT_TRUE(set_from_text(fields[1], " 7 "));
  EXPECT_TRUE(set_from_text(fields[2], "1.5"));
  EXPECT_TRUE(set_from_text(fields[3], "probability"));
  EXPECT_TRUE(set_from_text(fields[4], "old town"));
  EXPECT_TRUE(set_from_text(fields[5], "[10, 20,30]"));
  EXPECT_FALSE(values.enabled);
  EXPECT_EQ(values.count, 7);
  EXPECT_EQ(values.cell_m, 1.5);
  EXPECT_EQ(values.rule, "probability");
  EXPECT_EQ(values.title, "old town");
  EXPECT_EQ(values.ranges_m, (std::vector<double>{10.0, 20.0, 30.0}));
}

TEST(Options, ReadLooksFromTheCheapestToTheDearest) {
  Values values;
  std::vector<OptionField> fields = fields_of(values);
  ASSERT_TRUE(set_from_text(fields[6], "100 m, 400 returns, 32 points;100 m, 650 returns"));
  ASSERT_EQ(values.looks.size(), 2U);
  EXPECT_EQ(to_text(fields[6]), "100 m, 400 returns, 32 points; 100 m, 650 returns");
  Values again;
  std::vector<OptionField> fields_again = fields_of(again);
  ASSERT_TRUE(set_from_text(fields_again[6], to_text(fields[6])));
  EXPECT_EQ(again.looks, values.looks);
  const Error dearer_first = failure_of(
      set_from_text(fields[6], "100 m, 1944 returns, 80 points; 100 m, 650 returns, 40 points"));
  EXPECT_NE(dearer_first.message.find("takes less time than"), std::string::npos);
  EXPECT_FALSE(set_from_text(fields[6], "50 m")) << "a range takes every return";
  EXPECT_FALSE(set_from_text(fields[6], "100 m, 400 returns; 100 m, 400 returns"));
  EXPECT_EQ(values.looks, again.looks) << "the old value stands";
  ASSERT_TRUE(set_from_text(fields[6], "paper"));
  EXPECT_TRUE(values.looks.empty());
  EXPECT_EQ(to_text(fields[6]), "paper");
}

TEST(Options, RefuseWhatLiesOutsideAndKeepTheOldValue) {
  Values values;
  std::vector<OptionField> fields = fields_of(values);
  const std::vector<std::pair<std::size_t, std::string>> wrong = {
      {0, "yes"},   {1, "11"},     {1, "2.5"},     {1, ""},        {2, "0.01"},
      {2, "nan"},   {2, "2.0 m"},  {2, "inf"},     {3, "median"},  {5, ""},
      {5, "10, 5"}, {5, "10, 10"}, {5, "10, ten"}, {5, "10, 500"}, {5, "10,,20"}};
  for (const auto& [index, value] : wrong) {
    const Result<void> set = set_from_text(fields[index], value);
    ASSERT_FALSE(set.has_value()) << fields[index].name << " = " << value;
    EXPECT_EQ(set.error().code, ErrorCode::kBadValue);
    EXPECT_NE(set.error().message.find(fields[index].name), std::string::npos);
  }
  EXPECT_EQ(values.count, 3);
  EXPECT_EQ(values.cell_m, 2.0);
  EXPECT_EQ(values.ranges_m.size(), 2U);
}

TEST(Options, ReadBackWhatTheyPrintToTheLastBit) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    Values values;
    values.cell_m = random.uniform(0.1, 100.0);
    values.ranges_m = {random.uniform(1.0, 50.0), random.uniform(50.0, 200.0)};
    Values back;
    std::vector<OptionField> from = fields_of(values);
    std::vector<OptionField> to = fields_of(back);
    for (std::size_t f = 0; f < from.size(); ++f) {
      ASSERT_TRUE(set_from_text(to[f], to_text(from[f])));
    }
    ASSERT_EQ(back.cell_m, values.cell_m);
    ASSERT_EQ(back.ranges_m, values.ranges_m);
  }
}

TEST(NearestName, FindsTypingErrorsAndDoesNotGuess) {
  const std::vector<std::string> known = {"cell_m", "tile_m", "min_points"};
  EXPECT_EQ(nearest_name("cel_m", known), "cell_m");
  EXPECT_EQ(nearest_name("minpoints", known), "min_points");
  EXPECT_EQ(nearest_name("colour", known), "");
}

TEST(NearestName, AllowsOneErrorInThreeLetters) {
  EXPECT_EQ(nearest_name("foo", {"root", "key"}), "") << "two letters differ";
  EXPECT_EQ(nearest_name("nd", {"nds"}), "nds");
  EXPECT_EQ(nearest_name("gaet", {"gate"}), "gate") << "a swap is one error";
  EXPECT_EQ(nearest_name("complie", {"compile"}), "compile");
}

}  // namespace
}  // namespace sightline
