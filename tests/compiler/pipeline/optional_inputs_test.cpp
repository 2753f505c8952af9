// Passes with inputs that may be missing, and with lists of inputs.

#include <gtest/gtest.h>

#include <filesystem>

#include "compiler/pipeline/runner.h"
#include "formats/annotation/site_column.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

double number_of(const SiteColumn* column) { return column == nullptr ? 0.0 : column->values[0]; }

// The digits of a decimal number: `hundreds`, then `tens`, then one digit after the point for each
// of `rest`.
Result<SiteColumn> digits(PassContext&, const NoOptions&, const SiteColumn* hundreds,
                          const SiteColumn* tens, const SiteColumn& ones, Many<SiteColumn> rest) {
  double value = 100.0 * number_of(hundreds) + 10.0 * number_of(tens) + ones.values[0];
  double unit = 0.1;
  for (const SiteColumn* digit : rest) {
    value += unit * digit->values[0];
    unit *= 0.1;
  }
  return SiteColumn{"digits", "", {static_cast<float>(value)}};
}
constexpr Pass kDigits{"digits", 1, "number", "A decimal number", &digits};

Result<SiteColumn> count(PassContext&, const NoOptions&, Many<SiteColumn> first,
                         Many<SiteColumn> second) {
  return SiteColumn{"count", "", {static_cast<float>(10 * first.size() + second.size())}};
}
constexpr Pass kCount{"count", 1, "counts", "How many there are", &count};

class OptionalInputs : public ::testing::Test {
 protected:
  void SetUp() override { options_.cache_directory = scratch_folder(); }
  void TearDown() override { std::filesystem::remove_all(options_.cache_directory); }

  // Three inputs: the digits 1, 2 and 3.
  void begin() {
    plan_ = Plan();
    artifacts_ = {};
    for (const int digit : {1, 2, 3}) {
      const Wire<SiteColumn> wire = plan_.input<SiteColumn>("digit-" + std::to_string(digit));
      artifacts_.provide(wire, SiteColumn{"digit", "", {static_cast<float>(digit)}});
      digit_[static_cast<std::size_t>(digit)] = wire;
    }
  }
  float made(Wire<SiteColumn> wanted) {
    std::vector<StepReport> reports;
    const Result<void> done = run_plan(plan_, {wanted}, options_, {}, artifacts_, reports);
    EXPECT_TRUE(done) << to_string(done.error());
    is_from_cache_ = reports.back().from_cache;
    return artifacts_.get(wanted).values[0];
  }

  Plan plan_;
  ArtifactSet artifacts_;
  std::array<Wire<SiteColumn>, 4> digit_;
  RunOptions options_;
  bool is_from_cache_ = false;
};

TEST_F(OptionalInputs, AMissingOneIsNullAndAListKeepsItsOrder) {
  begin();
  EXPECT_FLOAT_EQ(made(plan_.run_as("all", kDigits, {}, digit_[1], digit_[2], digit_[3],
                                    {digit_[3], digit_[1]})),
                  123.31F);
  EXPECT_FLOAT_EQ(made(plan_.run_as("least", kDigits, {}, {}, {}, digit_[3], {})), 3.0);
  EXPECT_FLOAT_EQ(made(plan_.run_as("no tens", kDigits, {}, digit_[1], {}, digit_[3], {})), 103.0);
  const Wire<SiteColumn> never_connected;
  EXPECT_FLOAT_EQ(
      made(plan_.run_as("of the user", kDigits, {}, never_connected, digit_[2], digit_[3], {})),
      23.0);
}

// The same artifacts in the same order: only which parameter has them differs.
TEST_F(OptionalInputs, TheKeyContainsWhichParameterHasWhich) {
  begin();
  EXPECT_FLOAT_EQ(made(plan_.run(kDigits, digit_[1], {}, digit_[3], {})), 103.0);
  begin();
  EXPECT_FLOAT_EQ(made(plan_.run(kDigits, {}, digit_[1], digit_[3], {})), 13.0);
  begin();
  EXPECT_FLOAT_EQ(made(plan_.run(kDigits, digit_[1], {}, digit_[3], {})), 103.0);
  EXPECT_TRUE(is_from_cache_);
  EXPECT_FLOAT_EQ(made(plan_.run(kCount, {digit_[1], digit_[2]}, {digit_[3]})), 21.0);
  begin();
  EXPECT_FLOAT_EQ(made(plan_.run(kCount, {digit_[1]}, {digit_[2], digit_[3]})), 12.0);
}

// What a step runs in, when the plan is shared by several processes.
TEST_F(OptionalInputs, AStepRunsInNoEarlierStageThanWhatMakesItsInputs) {
  begin();
  const Wire<SiteColumn> late =
      plan_.run_as("late", kDigits.in(Stage::kSites), {}, {}, {}, digit_[1], {});
  plan_.run_as("early", kDigits, {}, {}, {}, digit_[1], {});
  plan_.run_as("no stage", kDigits, {}, late, {}, digit_[1], {});
  plan_.run_as("too early", kDigits.in(Stage::kGraph), {}, {}, {}, digit_[1], {digit_[2], late});
  std::vector<Stage> stages;
  for (const PassStep& step : plan_.steps()) stages.push_back(step.stage);
  EXPECT_EQ(stages,
            (std::vector<Stage>{Stage::kSites, Stage::kDrives, Stage::kSites, Stage::kSites}));
}

// Wires of another type, or a missing one where the pass needs it, do not fit.
struct Other {};
template <class A, class B>
concept Fits = requires(Plan& plan, A hundreds, Wire<SiteColumn> ones, std::vector<Wire<B>> rest) {
  plan.run(kDigits, hundreds, hundreds, ones, rest);
};
static_assert(Fits<Wire<SiteColumn>, SiteColumn>);
static_assert(Fits<Maybe<SiteColumn>, SiteColumn>);
static_assert(!Fits<Wire<Other>, SiteColumn>);
static_assert(!Fits<Wire<SiteColumn>, Other>);
template <class A>
concept IsNeeded = requires(Plan& plan, A ones) {
  plan.run(kDigits, Maybe<SiteColumn>(), Maybe<SiteColumn>(), ones, {});
};
static_assert(IsNeeded<Wire<SiteColumn>> && !IsNeeded<Maybe<SiteColumn>>);

}  // namespace
}  // namespace sightline
