#include "compiler/pipeline/schedule.h"

#include <gtest/gtest.h>

#include <map>

#include "formats/annotation/site_column.h"

namespace sightline {

struct TwoTexts {
  std::string first;
  std::string second;
};
std::vector<OptionField> option_fields(TwoTexts& options) {
  return {text("first", options.first, "a text"), text("second", options.second, "another")};
}

namespace {

Result<SiteColumn> copy(PassContext&, const TwoTexts&, const SiteColumn& column) { return column; }
constexpr Pass kCopy{"copy", 1, "copied", "A column again", &copy};
Result<SiteColumn> first_of(PassContext&, const NoOptions&, const SiteColumn& a,
                            const SiteColumn&) {
  return a;
}
constexpr Pass kFirst{"first", 1, "first", "The first of two columns", &first_of};

// Of the last step. Contents of inputs by their names in the plan.
StepKey key_of(const Plan& plan, const std::map<std::string, std::string>& contents) {
  return step_key(plan, plan.steps().back(), /*seed=*/1, [&](std::size_t artifact) {
    return sha256(contents.at(plan.artifact({artifact}).name));
  });
}

StepKey key_with(const TwoTexts& options) {
  Plan plan;
  plan.run_as("", kCopy, options, plan.input<SiteColumn>("source"));
  return key_of(plan, {{"source", "a drive"}});
}

StepKey key_under(const std::string& label, const std::string& input, const std::string& content) {
  Plan plan;
  plan.run_as(label, kCopy, {}, plan.input<SiteColumn>(input));
  return key_of(plan, {{input, content}});
}

TEST(StepKey, IsOfContentsWhateverTheyAreCalled) {
  const StepKey key = key_under("mapping", "mapping/drive", "a drive");
  EXPECT_EQ(key.key, key_under("mapping[2]", "mapping[2]/drive", "a drive").key);
  EXPECT_EQ(key.key, key_under("", "drive", "a drive").key);
  EXPECT_NE(key.key, key_under("mapping", "mapping/drive", "another drive").key);
}

TEST(StepKey, IsOfTheOrderOfInputs) {
  Plan plan;
  const Wire<SiteColumn> a = plan.input<SiteColumn>("a");
  const Wire<SiteColumn> b = plan.input<SiteColumn>("b");
  plan.run(kFirst, a, b);
  const StepKey key = key_of(plan, {{"a", "1"}, {"b", "2"}});
  EXPECT_NE(key.key, key_of(plan, {{"a", "2"}, {"b", "1"}}).key);
  plan.run_as("turned", kFirst, {}, b, a);
  EXPECT_EQ(key.key, key_of(plan, {{"a", "2"}, {"b", "1"}}).key);
}

TEST(StepKey, OfTwoStepsWithDifferentOptionsIsNeverOne) {
  const std::vector<TwoTexts> all = {{"1", "2"},
                                     {"1\noption second = 2", ""},
                                     {"1\\noption second = 2", ""},
                                     {"1\noption second = 2", "3"},
                                     {"1", "2\noption second = 3"},
                                     {"1 = 2", ""},
                                     {"1", "2\n"},
                                     {"1", "2\\n"},
                                     {"1\noption second = 2\noption second = ", ""}};
  std::map<std::string, std::size_t> records;
  std::map<Digest, std::size_t> ways;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const StepKey key = key_with(all[i]);
    const auto [record, is_new] = records.try_emplace(key.record, i);
    EXPECT_TRUE(is_new) << i << " and " << record->second << " have one record:\n" << key.record;
    EXPECT_TRUE(ways.try_emplace(key.way, i).second) << i;
  }
}

TEST(StepKey, HasARecordOfOneLineForEachOption) {
  const StepKey before = key_with({"1", "2"});
  EXPECT_EQ(reason_to_run(before.record, key_with({"1\noption second = 2", "2"}).record),
            "option first was 1, is 1\\noption second = 2");
}

}  // namespace
}  // namespace sightline
