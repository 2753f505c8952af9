#include "compiler/pipeline/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/annotation/site_column.h"

namespace sightline {

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
struct Other {};
static_assert(FitsSlope<SiteColumn>);
static_assert(!FitsSlope<Other>);

}  // namespace
}  // namespace sightline
