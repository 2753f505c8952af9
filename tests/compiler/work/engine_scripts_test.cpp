#include "compiler/work/engine_scripts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// What an engine makes of a script is tried in tests/system/cluster.
EngineJob job() {
  return {"/usr/bin/sightline", "/maps/50% of $town's {a}", "/maps/town.slmap", "abc", 3};
}

TEST(EngineScripts, TellSbatchThatAPercentSignIsOne) {
  const std::string script = engine_script("slurm", job());
  EXPECT_THAT(script, HasSubstr("--output='/maps/50%% of $town'\\''s {a}/log'/sites-%a.log"));
  EXPECT_THAT(script, HasSubstr("mkdir -p '/maps/50% of $town'\\''s {a}/log'\n"));
}

TEST(EngineScripts, TellMakeThatADollarSignIsOne) {
  EXPECT_THAT(engine_script("make", job()), HasSubstr("work '/maps/50% of $$town'\\''s {a}'"));
}

// Snakemake keeps marks of what is done: another plan in the same folder, or other shares, have
// their own.
TEST(EngineScripts, MarksOfSnakemakeAreOfOnePlanAndItsShares) {
  EngineJob other = job();
  const std::string script = engine_script("snakemake", other);
  EXPECT_THAT(script, HasSubstr("touch(\"done/abc/sites-{share}-of-3\")"));
  EXPECT_THAT(script, HasSubstr("{{a}}"));
  other.plan_digest = "def";
  EXPECT_THAT(engine_script("snakemake", other), Not(HasSubstr("done/abc")));
  other.shares = 4;
  EXPECT_THAT(engine_script("snakemake", other), HasSubstr("done/def/sites-{share}-of-4"));
}

}  // namespace
}  // namespace sightline
