#include <gtest/gtest.h>

#include <map>

#include "compiler/driver/pipelines.h"

namespace sightline {
namespace {

// Every kind of compile there is.
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

// Else a process would wait for what comes after it.
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
