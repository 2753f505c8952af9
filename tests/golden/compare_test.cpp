#include "tests/golden/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline::golden {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

StepOutput step(const std::string& name, const std::string& content,
                std::vector<std::string> inputs) {
  StepOutput output;
  output.step = name;
  output.version_constant = "kVersionOf_" + name;
  output.version = 3;
  output.artifact = "of-" + name;
  output.encoding = "thing 1";
  output.inputs = std::move(inputs);
  output.digest = sha256(content);
  output.table.columns = {"x_m"};
  output.table.rows = {{content}};
  return output;
}

// inputs -> first -> second, and third beside them.
std::vector<RunOutput> town() {
  StepOutput inputs = step("inputs", "recordings", {});
  inputs.version_constant = "";
  return {{"town",
           {inputs, step("first", "one", {"of-inputs"}), step("second", "two", {"of-first"}),
            step("third", "three", {"of-inputs"})}}};
}

StepOutput& first(std::vector<RunOutput>& runs) { return runs[0].steps[1]; }
StepOutput& second(std::vector<RunOutput>& runs) { return runs[0].steps[2]; }

void change(const std::string& content, StepOutput& output) {
  output.digest = sha256(content);
  output.table.rows = {{content}};
}

TEST(GoldenCompare, SaysNothingWhereNothingChanged) {
  EXPECT_EQ(compare(town(), golden_files(town())), "");
}

TEST(GoldenCompare, NamesThePassThatChangedUnderItsOldVersionAndThoseAfterIt) {
  std::vector<RunOutput> now = town();
  change("1", first(now));
  change("2", second(now));
  const std::string text = compare(now, golden_files(town()));
  EXPECT_THAT(text, HasSubstr("first: output changed, its version 3 did not: raise "
                              "kVersionOf_first or find out why\n  town/first.txt"));
  EXPECT_THAT(text, AllOf(HasSubstr("  - 0,one\n  + 0,1\n"), HasSubstr("after it: town/second\n")));
  EXPECT_THAT(text, AllOf(Not(HasSubstr("kVersionOf_second")), Not(HasSubstr("third"))));
}

TEST(GoldenCompare, NamesAPassInALaterRunAsAfterTheOneThatChanged) {
  std::vector<RunOutput> before = town();
  before.push_back({"town-evaluate", {step("fourth", "four", {"of-second"})}});
  std::vector<RunOutput> now = before;
  change("2", second(now));
  change("4", now[1].steps[0]);
  const std::string text = compare(now, golden_files(before));
  EXPECT_THAT(text, HasSubstr("second: output changed"));
  EXPECT_THAT(text, HasSubstr("after it: town-evaluate/fourth\n"));
}

TEST(GoldenCompare, AsksForAnUpdateOnceTheVersionIsRaised) {
  std::vector<RunOutput> now = town();
  change("1", first(now));
  first(now).version = 4;
  EXPECT_THAT(compare(now, golden_files(town())),
              HasSubstr("first: output changed and its version went from 3 to 4: run "
                        "tests/update_golden.sh"));
  now = town();
  first(now).version = 4;
  EXPECT_THAT(compare(now, golden_files(town())),
              HasSubstr("first: version 3 became 4, the output is the same here"));
}

TEST(GoldenCompare, TellsAChangedDumpFromAChangedArtifact) {
  std::vector<RunOutput> now = town();
  first(now).table.columns = {"y_m"};
  EXPECT_THAT(compare(now, golden_files(town())),
              HasSubstr("first: its dump changed, the artifact did not"));
}

TEST(GoldenCompare, TellsChangedInputsFromChangedPasses) {
  std::vector<RunOutput> now = town();
  change("other recordings", now[0].steps[0]);
  EXPECT_THAT(compare(now, golden_files(town())), HasSubstr("inputs: what the passes are given"));
}

TEST(GoldenCompare, MissesNoStepAndNoFile) {
  GoldenFiles kept = golden_files(town());
  kept.erase("town/third.txt");
  kept["town/gone.txt"] = "step: gone\n";
  const std::string text = compare(town(), kept);
  EXPECT_THAT(text, HasSubstr("third: no golden file yet"));
  EXPECT_THAT(text, HasSubstr("town/gone.txt: belongs to no step"));
}

}  // namespace
}  // namespace sightline::golden
