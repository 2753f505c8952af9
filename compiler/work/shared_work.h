#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/config/compile_config.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/plans.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/pipeline/runner.h"
#include "formats/base/result.h"

// A compile that several processes, on any number of machines, do together: each opens the plan,
// does a share of a stage and leaves what it made in the store of the plan. There are no locks, and
// no worker needs to know of the others: what is made twice has the same bytes.

namespace sightline {

struct PlannedRecording {
  std::string role;    // section of the configuration: "mapping", "localization", ...
  std::string digest;  // hexadecimal
  friend bool operator==(const PlannedRecording&, const PlannedRecording&) = default;
};

// What a plan folder says of the compile that it is for: `plan.json` in it
// (schemas/plan.schema.json). Finished work lies beside it, in `store`.
struct PlanFile {
  std::filesystem::path folder;              // in which `cluster plan` was called: paths begin here
  std::filesystem::path configuration;       // absolute
  std::vector<std::string> overrides;        // "section.key=value"
  std::filesystem::path model;               // absolute; empty: one is trained
  std::string values;                        // digest of every value that the configuration sets
  std::vector<PlannedRecording> recordings;  // as they were then
};

std::filesystem::path plan_file_in(const std::filesystem::path& plan);
std::filesystem::path store_in(const std::filesystem::path& plan);

std::string to_json(const PlanFile& plan);

// Reads plan.json of a plan folder. Errors: file-not-found, too-large, malformed-text (no such
// JSON), future-version, missing-key.
Result<PlanFile> read_plan_file(const std::filesystem::path& plan);

struct SharedWork {
  CompileConfig config;
  CompilePlan compile;
  ArtifactSet artifacts;        // what the compile takes from outside
  std::filesystem::path store;  // absolute
};

// What a compile of this configuration is, for a plan folder. `folder` is that in which paths of
// `overrides` begin. Errors: those of load_compile_config and provide_drives, of read_model.
struct NewPlan {
  PlanFile file;
  SharedWork work;
};
Result<NewPlan> new_plan(const std::filesystem::path& plan,
                         const std::filesystem::path& configuration,
                         const std::vector<std::string>& overrides,
                         const std::filesystem::path& model);

// Opens a plan folder; the process goes to the folder in which the plan was made. Errors: those of
// read_plan_file and new_plan; mismatched-inputs (the configuration, the model or a recording is
// not what it was when the plan was made).
Result<SharedWork> open_work(const std::filesystem::path& plan);

// What the steps of a stage make that can be kept, in running order.
std::vector<AnyWire> outputs_of(const CompilePlan& compile, Stage stage);

// Of them: those that the process of this share makes first.
std::vector<AnyWire> share_of(const std::vector<AnyWire>& outputs, const WorkShare& share);

// How a process runs steps of a stage: in the store of the plan, and no steps of other stages.
// Refers to the work.
RunOptions options_in(const SharedWork& work, Stage stage);

// How far the steps of a plan are.
struct StepState {
  Stage stage = Stage::kDrives;
  std::string step;
  bool is_done = false;
  std::size_t parts_there = 0;
  std::size_t parts = 0;  // 0: not begun, or it has none
};
std::vector<StepState> states_of(const SharedWork& work);
// As schemas/status.schema.json describes it.
std::string to_json(const std::vector<StepState>& states);

// What runs a plan: engines that a cluster has anyway.
struct EngineJob {
  std::filesystem::path program;  // this one, absolute
  std::filesystem::path plan;     // absolute
  std::filesystem::path map;      // to link, absolute
  // Of plan.json, hexadecimal: what was done for another plan does not count.
  std::string plan_digest;
  int shares = 1;  // of each stage that can be shared
};

std::vector<std::string> engine_names();  // "slurm", "make", "snakemake"

// A script that does all stages and links, for an engine of engine_names().
std::string engine_script(std::string_view engine, const EngineJob& job);

}  // namespace sightline
