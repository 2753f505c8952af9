#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>

#include "compiler/driver/pipelines.h"
#include "compiler/work/shared_work.h"
#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

PlanFile some_plan() {
  PlanFile plan;
  plan.folder = "/maps";
  plan.configuration = "/maps/city \"1\".yaml";
  plan.overrides = {"train-model.trees=20", "annotation.seed=7"};
  plan.model = "/maps/city.slmodel";
  plan.values = std::string(64, '0');
  plan.recordings = {{"mapping", std::string(64, 'a')}, {"localization", std::string(64, 'b')}};
  return plan;
}

class PlanFileTest : public TestInFolder {
 protected:
  Result<PlanFile> read(const std::string& text) {
    EXPECT_TRUE(write_file_atomically(plan_file_in(folder_), text, IfExists::kReplace));
    return read_plan_file(folder_);
  }
  ErrorCode failure(const std::string& text) { return code_of(read(text)); }
};

TEST_F(PlanFileTest, IsReadBackAsItWasWritten) {
  const PlanFile plan = some_plan();
  const PlanFile read_back = value_of(read(to_json(plan)));
  EXPECT_EQ(read_back.folder, plan.folder);
  EXPECT_EQ(read_back.configuration, plan.configuration);
  EXPECT_EQ(read_back.overrides, plan.overrides);
  EXPECT_EQ(read_back.model, plan.model);
  EXPECT_EQ(read_back.values, plan.values);
  EXPECT_EQ(read_back.recordings, plan.recordings);
}

TEST_F(PlanFileTest, KeepsToItsSchema) {
  using Json = nlohmann::json;
  const Json schema =
      Json::parse(*read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/plan.schema.json"));
  Json plan = Json::parse(to_json(some_plan()));
  EXPECT_EQ(schema_faults(schema, plan), "");
  plan["values"] = "short";
  EXPECT_NE(schema_faults(schema, plan), "");
}

TEST(StepStates, KeepToTheirSchema) {
  using Json = nlohmann::json;
  const Json schema =
      Json::parse(*read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/status.schema.json"));
  const std::vector<StepState> states = {{Stage::kDrives, "ingest", true, 0, 0},
                                         {Stage::kSites, "measure-error", false, 3, 8}};
  Json json = Json::parse(to_json(states));
  EXPECT_EQ(schema_faults(schema, json), "");
  EXPECT_EQ(json[1]["stage"], "sites");
  EXPECT_EQ(json[1]["parts_there"], 3);
  for (const std::string_view stage : kStageNames) {
    json[0]["stage"] = stage;
    EXPECT_EQ(schema_faults(schema, json), "");
  }
  json[0]["stage"] = "elsewhere";
  EXPECT_NE(schema_faults(schema, json), "");
}

TEST_F(PlanFileTest, IsRefusedWhereItIsNone) {
  EXPECT_EQ(read_plan_file(folder_).error().code, ErrorCode::kFileNotFound);
  EXPECT_EQ(failure(""), ErrorCode::kMalformedText);
  EXPECT_EQ(failure("[1, 2]"), ErrorCode::kMalformedText);
  EXPECT_EQ(failure("{\"map\": 1}"), ErrorCode::kMalformedText);
  EXPECT_EQ(failure("{\"sightline_plan\": 2}"), ErrorCode::kFutureVersion);
  EXPECT_EQ(failure("{\"sightline_plan\": \"1\"}"), ErrorCode::kFutureVersion);
  EXPECT_EQ(failure("{\"sightline_plan\": 1}"), ErrorCode::kMissingKey);
  std::string text = to_json(some_plan());
  const std::size_t digest = text.find("\"aaaa");
  ASSERT_NE(digest, std::string::npos);
  EXPECT_EQ(failure(text.replace(digest, 66, "17")), ErrorCode::kMissingKey);
}

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

std::vector<CompileConfig> all_kinds() {
  CompileConfig split;
  split.mapping.scans = "any";
  CompileConfig two = split;
  two.localization.scans = "other";
  CompileConfig wide = two;
  wide.other_sensors.front().scans = "rear";
  wide.later_mapping.resize(2);
  for (RecordingOptions& later : wide.later_mapping) later.scans = "later";
  CompileConfig several = two;
  several.later_localization.resize(2);
  for (RecordingOptions& later : several.later_localization) later.scans = "later";
  CompileConfig imported = two;
  imported.outside.file = "errors.csv";
  CompileConfig finished;
  finished.map.points = "map";
  CompileConfig finished_and_driven = finished;
  finished_and_driven.localization.scans = "drive";
  CompileConfig field = finished;
  field.map.points = "map.slmap";
  field.map.is_compiled = true;
  field.route.file = "everywhere";
  CompileConfig extended = two;
  extended.later_mapping.resize(1);
  extended.later_mapping.front().scans = "later";
  extended.base_poses = "old.slposes";
  CompileConfig wide_extended = wide;
  wide_extended.base_poses = "old.slposes";
  return {split, two,      wide,         several, imported, finished, finished_and_driven,
          field, extended, wide_extended};
}

TEST(Stages, NoStepTakesWhatALaterStageMakes) {
  for (const CompileConfig& config : all_kinds()) {
    for (const ModelSource model : {ModelSource::kTrained, ModelSource::kGiven}) {
      const Plan plan = compile_plan(config, model).plan;
      std::map<std::size_t, Stage> made_in;
      for (const PassStep& step : plan.steps()) {
        const Stage stage = step.stage;
        for (const std::size_t input : step.inputs) {
          if (!made_in.contains(input)) continue;
          EXPECT_LE(made_in[input], stage) << step.name;
        }
        made_in[step.output] = stage;
      }
    }
  }
}

// What every process would do for itself had better be little: joining and undistorting, which
// only say how scans are read; and the map is written by one.
TEST(Stages, WaysToReadScansAndTheMapAloneAreKeptByNobody) {
  for (const CompileConfig& config : all_kinds()) {
    const Plan plan = compile_plan(config).plan;
    for (const PassStep& step : plan.steps()) {
      if (can_be_kept(plan, step)) continue;
      EXPECT_TRUE(step.name.starts_with("join-") || step.name.starts_with("undistort-scans") ||
                  step.name == "released-drive" || step.stage == Stage::kLink)
          << step.name;
    }
  }
}

}  // namespace
}  // namespace sightline
