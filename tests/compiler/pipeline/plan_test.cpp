#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compiler/pipeline/plan.h"
#include "compiler/pipeline/runner.h"
#include "formats/annotation/site_column.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

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

class OptionalInputs : public TestInFolder {
 protected:
  OptionalInputs() { options_.cache_directory = folder_; }

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
    require(run_plan(plan_, {wanted}, options_, {}, artifacts_, reports));
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
struct NoColumn {};
template <class A, class B>
concept Fits = requires(Plan& plan, A hundreds, Wire<SiteColumn> ones, std::vector<Wire<B>> rest) {
  plan.run(kDigits, hundreds, hundreds, ones, rest);
};
static_assert(Fits<Wire<SiteColumn>, SiteColumn>);
static_assert(Fits<Maybe<SiteColumn>, SiteColumn>);
static_assert(!Fits<Wire<NoColumn>, SiteColumn>);
static_assert(!Fits<Wire<SiteColumn>, NoColumn>);
template <class A>
concept IsNeeded = requires(Plan& plan, A ones) {
  plan.run(kDigits, Maybe<SiteColumn>(), Maybe<SiteColumn>(), ones, {});
};
static_assert(IsNeeded<Wire<SiteColumn>> && !IsNeeded<Maybe<SiteColumn>>);

}  // namespace

struct SlopeOptions {
  double slope = 2.0;
  double leaf_m = 1.0;
};
std::vector<OptionField> option_fields(SlopeOptions& options) {
  return {number("slope", options.slope, "what to multiply by", -10.0, 10.0),
          shared(number("leaf_m", options.leaf_m, "voxel, m", 0.1, 10.0))};
}

namespace {

using testing::ElementsAre;

Result<SiteColumn> slope(PassContext&, const SlopeOptions& options, const SiteColumn& column) {
  SiteColumn sloped = column;
  for (float& value : sloped.values) value *= static_cast<float>(options.slope);
  return sloped;
}
constexpr Pass kSlope{"slope", 3, "sloped", "Values times a number", &slope};

Result<SiteColumn> sum(PassContext&, const NoOptions&, const SiteColumn& a, const SiteColumn&) {
  return a;
}
constexpr Pass kSum{"sum", 1, "sum", "The sum of two columns", &sum};

std::vector<std::string> names_of(const Plan& plan, const std::vector<std::size_t>& steps) {
  std::vector<std::string> names;
  for (const std::size_t step : steps) names.push_back(plan.steps()[step].name);
  return names;
}

bool nothing_is_there(AnyWire) { return false; }

TEST(Plan, ReadsNameVersionAndTableOffThePass) {
  Plan plan;
  const Wire<SiteColumn> sloped = plan.run(kSlope, plan.input<SiteColumn>("source"));
  EXPECT_EQ(plan.steps().front().name, "slope");
  EXPECT_EQ(plan.steps().front().version, 3u);
  EXPECT_EQ(plan.artifact(sloped).name, "sloped");
  EXPECT_EQ(plan.find("sloped"), sloped.any());
  EXPECT_EQ(plan.find("source"), AnyWire{}) << "no step makes it";
}

TEST(Plan, GivesPassesTheirOwnAndTheSharedSettings) {
  PassSettings settings;
  settings.own["slope"]["slope"] = "4";
  settings.own["slope"]["leaf_m"] = "9";  // shared: not the pass's own to set
  settings.shared["leaf_m"] = "0.5";
  settings.shared["slope"] = "7";  // own: not to be set by others
  const Plan plan(settings);
  EXPECT_EQ(plan.options(kSlope).slope, 4.0);
  EXPECT_EQ(plan.options(kSlope).leaf_m, 0.5);
}

TEST(Plan, PublishesEachPassOnceWithTheFieldsOfItsOwn) {
  Plan plan;
  const Wire<SiteColumn> once = plan.run(kSlope, plan.input<SiteColumn>("source"));
  const Wire<SiteColumn> twice = plan.run_as("again", kSlope, {}, once);
  plan.run(kSum, once, twice);
  ASSERT_EQ(plan.sections().size(), 1u);
  EXPECT_EQ(plan.sections().front().name, "slope");
  ASSERT_EQ(plan.sections().front().fields.size(), 1u);
  EXPECT_EQ(plan.sections().front().fields.front().name, "slope");
  EXPECT_EQ(plan.artifact(twice).name, "again/sloped");
  EXPECT_EQ(plan.steps()[1].name, "slope:again");
}

TEST(Plan, NamesTheStepsThatAnArtifactNeedsAndNoOthers) {
  Plan plan;
  const Wire<SiteColumn> source = plan.input<SiteColumn>("source");
  const Wire<SiteColumn> a = plan.run_as("a", kSlope, {}, source);
  const Wire<SiteColumn> b = plan.run_as("b", kSlope, {}, source);
  const Wire<SiteColumn> c = plan.run_as("c", kSlope, {}, a);
  const Wire<SiteColumn> total = plan.run(kSum, c, b);
  EXPECT_THAT(names_of(plan, steps_for(plan, {c}, nothing_is_there)),
              ElementsAre("slope:a", "slope:c"));
  EXPECT_THAT(names_of(plan, steps_for(plan, {}, nothing_is_there)),
              ElementsAre("slope:a", "slope:b", "slope:c", "sum"));
  const auto has_c = [&](AnyWire wire) { return wire == c.any(); };
  EXPECT_THAT(names_of(plan, steps_for(plan, {total}, has_c)), ElementsAre("slope:b", "sum"));
}

// A wire of another type does not fit: this is what the compiler decides.
template <class X>
concept FitsSlope = requires(Plan& plan, Wire<X> wire) {
  plan.run(kSlope, wire);
};
static_assert(FitsSlope<SiteColumn>);
static_assert(!FitsSlope<NoColumn>);

}  // namespace
}  // namespace sightline
