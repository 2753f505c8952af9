#include "compiler/work/shared_work.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "compiler/driver/model_source.h"
#include "compiler/driver/pipelines.h"
#include "compiler/pipeline/schedule.h"
#include "compiler/store/cache.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/version.h"
#include "formats/text/json_text.h"
#include "formats/text/quoted_text.h"
#include "passes/pass/pass.h"

namespace sightline {
namespace {

std::string digest_of(const CompileConfig& config) {
  DigestBuilder builder;
  for (const EffectiveValue& value : effective_values(config)) {
    builder.add(std::string_view(concat(value.section, ".", value.key, "=", value.value, "\n")));
  }
  return to_hex(builder.finish());
}

Error changed(const std::string& what, const std::filesystem::path& plan) {
  return {ErrorCode::kMismatchedInputs,
          what +
              " changed since the plan was made; make the plan again (finished work that is still "
              "valid is kept)",
          plan_file_in(plan).string()};
}

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr std::size_t kLongest = std::size_t{1} << 24;  // bytes; a plan names drives, not scans

// Values of a JSON object, with the first that is missing or of another type remembered.
class Fields {
 public:
  explicit Fields(const Json& json) : json_(json) {}

  [[nodiscard]] std::string text(const char* name) {
    const auto found = json_.find(name);
    if (found != json_.end() && found->is_string()) return found->get<std::string>();
    miss(name);
    return {};
  }
  [[nodiscard]] const Json& list(const char* name) {
    static const Json kEmpty = Json::array();
    const auto found = json_.find(name);
    if (found != json_.end() && found->is_array()) return *found;
    miss(name);
    return kEmpty;
  }
  void miss(const std::string& name) {
    if (missing_.empty()) missing_ = name;
  }
  [[nodiscard]] const std::string& missing() const { return missing_; }

 private:
  const Json& json_;
  std::string missing_;
};

// A file name of sbatch, where % begins what it replaces.
std::string sbatch_name(const std::string& path) {
  std::string name;
  for (const char c : path) name += c == '%' ? "%%" : std::string(1, c);
  return shell_word(name);
}

std::string work_command(const EngineJob& job, Stage stage) {
  return concat(shell_word(job.program.string()), " cluster work ", shell_word(job.plan.string()),
                " --stage ", stage_name(stage));
}

std::string link_command(const EngineJob& job) {
  return concat(shell_word(job.program.string()), " cluster link ", shell_word(job.plan.string()),
                " -o ", shell_word(job.map.string()), " --force");
}

int shares_of(const EngineJob& job, Stage stage) { return is_shared(stage) ? job.shares : 1; }

std::string slurm_script(const EngineJob& job) {
  const std::string threads = " --threads \"${SLURM_CPUS_PER_TASK:-1}\"";
  const std::string folder = (job.plan / "log").string();
  const std::string logs = sbatch_name(folder);
  std::string text = concat(
      "#!/bin/bash\n"
      "# Submits the work of one plan to Slurm: a job array for each stage, then the link. Work "
      "that a\n"
      "# lost node left unfinished is done first by the next stage, so a failed task needs no "
      "repair.\n"
      "# usage: bash THIS_SCRIPT [options of sbatch, such as --partition=maps --mem=2G]\n"
      "set -euo pipefail\n"
      "mkdir -p ",
      shell_word(folder),
      "\n"
      "submit() { sbatch --parsable --requeue --open-mode=append \"$@\"; }\n");
  std::string before;
  std::string finished;  // commands that finish the stages before
  for (const Stage stage : kWorkStages) {
    const std::string name(stage_name(stage));
    const std::string count = std::to_string(shares_of(job, stage));
    text += concat(name, "=$(submit \"$@\" --job-name=sightline-", name, " --array=1-", count,
                   " --output=", logs, "/", name, "-%a.log",
                   (before.empty() ? "" : " --dependency=afterany:$" + before), " <<'TASK'\n",
                   "#!/bin/bash\nset -e\n", finished, "exec ", work_command(job, stage),
                   " --share \"$SLURM_ARRAY_TASK_ID/", count, "\"", threads, "\nTASK\n)\n");
    finished += concat(work_command(job, stage), threads, "\n");
    before = name;
  }
  text += concat("link=$(submit \"$@\" --job-name=sightline-link --output=", logs,
                 "/link-%j.log --dependency=afterany:$", before, " <<'TASK'\n#!/bin/bash\nset -e\n",
                 finished, "exec ", link_command(job), "\nTASK\n)\n", "echo \"$link\"\n");
  return text;
}

std::string make_script(const EngineJob& job) {
  const auto for_make = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('$', at)) != std::string::npos; at += 2) {
      text.insert(at, "$");
    }
    return text;
  };
  std::string rules;
  std::string before;
  for (const Stage stage : kWorkStages) {
    const int count = shares_of(job, stage);
    std::string stamps;
    for (int share = 1; share <= count; ++share) {
      const std::string number = std::to_string(share);
      const std::string target = concat("share-", stage_name(stage), "-", number);
      rules += concat(".PHONY: ", target, "\n", target, ":", before, "\n\t",
                      for_make(work_command(job, stage)), " --share ", number, "/", count,
                      " --threads 1\n");
      stamps += " " + target;
    }
    before = stamps;
  }
  return concat(
      "# The work of one plan for GNU make: make -f THIS_FILE -j SHARES\n"
      "# Run it again after an interruption; finished work is kept.\n"
      ".DELETE_ON_ERROR:\n"
      ".PHONY: link\n"
      "link:",
      before, "\n\t", for_make(link_command(job)), "\n", rules);
}

// A string of Python.
std::string python_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

// A command in a rule of Snakemake, where braces alone are wildcards.
std::string rule_text(const std::string& command) {
  std::string text;
  for (const char c : command) {
    if (c == '{' || c == '}') text += c;
    text += c;
  }
  return python_text(text);
}

std::string snakemake_script(const EngineJob& job) {
  std::string rules;
  std::string finished;
  std::string before;
  for (const Stage stage : kWorkStages) {
    const std::string name(stage_name(stage));
    const std::string count = std::to_string(shares_of(job, stage));
    const std::string done =
        python_text(concat("done/", job.plan_digest, "/", name, "-{share}-of-", count));
    rules += concat("\nrule ", name, ":\n", (before.empty() ? "" : "    input: " + before + "\n"),
                    "    output: touch(", done,
                    ")\n    shell: ", rule_text(work_command(job, stage) + " --share "),
                    " \"{wildcards.share}/", count, " --threads 1\"\n");
    finished += work_command(job, stage) + " && ";
    before = concat("expand(", done, ", share=range(1, ", count, " + 1))");
  }
  return concat(
      "# The work of one plan for Snakemake 7 and later: snakemake -s THIS_FILE --cores SHARES\n"
      "# Before linking, it does the work that the shares left unfinished.\n"
      "workdir: ",
      python_text(job.plan.string()), "\nrule link:\n    input: ", before,
      "\n    shell: ", rule_text(finished + link_command(job)), "\n", rules);
}

}  // namespace

Result<NewPlan> new_plan(const std::filesystem::path& plan,
                         const std::filesystem::path& configuration,
                         const std::vector<std::string>& overrides,
                         const std::filesystem::path& model) {
  NewPlan made;
  made.file.folder = std::filesystem::current_path();
  made.file.configuration = std::filesystem::absolute(configuration);
  made.file.overrides = overrides;
  SharedWork& work = made.work;
  work.store = std::filesystem::absolute(store_in(plan));
  SIGHTLINE_ASSIGN(work.config, load_compile_config(made.file.configuration, overrides));
  made.file.values = digest_of(work.config);
  SIGHTLINE_ASSIGN(const ChosenModel chosen, choose_model(work.config, model));
  const bool is_given = !chosen.file.empty();
  if (is_given) made.file.model = std::filesystem::absolute(chosen.file);
  work.compile = compile_plan(work.config, chosen.source());
  SIGHTLINE_TRY(provide_drives(work.compile, work.store, work.artifacts));
  if (is_given) {
    SIGHTLINE_TRY(provide_model(work.compile, made.file.model, work.artifacts));
    made.file.recordings.push_back(
        {"model", to_hex(work.artifacts.entry(work.compile.given_model).key)});
  }
  for (const RecordingCard& card : work.artifacts.get(work.compile.cards).cards) {
    made.file.recordings.push_back({card.role, to_hex(card.digest)});
  }
  return made;
}

Result<SharedWork> open_work(const std::filesystem::path& plan) {
  SIGHTLINE_ASSIGN(const PlanFile file, read_plan_file(plan));
  const std::filesystem::path here = std::filesystem::absolute(plan);
  std::error_code failure;
  std::filesystem::current_path(file.folder, failure);
  if (failure) {
    return Error{ErrorCode::kFileNotFound,
                 "the folder in which the plan was made does not exist: " + failure.message(),
                 file.folder.string()};
  }
  SIGHTLINE_ASSIGN(NewPlan now, new_plan(here, file.configuration, file.overrides, file.model));
  if (now.file.values != file.values) return changed("the configuration", here);
  for (const PlannedRecording& recording : file.recordings) {
    if (std::ranges::find(now.file.recordings, recording) == now.file.recordings.end()) {
      return changed(concat("'", recording.role, "'"), here);
    }
  }
  return std::move(now.work);
}

std::vector<AnyWire> outputs_of(const CompilePlan& compile, Stage stage) {
  const Plan& plan = compile.plan;
  std::vector<AnyWire> outputs;
  for (const std::size_t index :
       steps_for(plan, reported_artifacts(compile), [](AnyWire) { return false; })) {
    const PassStep& step = plan.steps()[index];
    if (can_be_kept(plan, step) && step.stage == stage) outputs.push_back({step.output});
  }
  return outputs;
}

std::vector<AnyWire> share_of(const std::vector<AnyWire>& outputs, const WorkShare& share) {
  const auto begin =
      outputs.begin() + static_cast<std::ptrdiff_t>(outputs.size() * share.number / share.of);
  const auto end =
      outputs.begin() + static_cast<std::ptrdiff_t>(outputs.size() * (share.number + 1) / share.of);
  return {begin, end};
}

RunOptions options_in(const SharedWork& work, Stage stage) {
  RunOptions options;
  options.seed = static_cast<std::uint64_t>(work.config.annotation.seed);
  options.cache_directory = work.store;
  options.may_run = [&plan = work.compile.plan, stage](const std::string& name) {
    return std::ranges::any_of(plan.steps(), [&](const PassStep& step) {
      return step.name == name && step.stage == stage;
    });
  };
  return options;
}

std::vector<StepState> states_of(const SharedWork& work) {
  const Plan& plan = work.compile.plan;
  const ArtifactCache cache = ArtifactCache::to_look_at(work.store);
  std::vector<StepState> states;
  for (const PlannedRun& run : planned_runs(plan, reported_artifacts(work.compile),
                                            options_in(work, Stage::kLink), work.artifacts)) {
    if (!run.is_kept) continue;
    StepState state{plan.steps()[run.step].stage, run.name, cache.has(run.name, run.key)};
    if (const auto parts = cache.part_count(run.name, run.key)) {
      state.parts = parts->all;
      state.parts_there = parts->there;
    }
    states.push_back(std::move(state));
  }
  return states;
}

std::filesystem::path plan_file_in(const std::filesystem::path& plan) { return plan / "plan.json"; }

std::filesystem::path store_in(const std::filesystem::path& plan) { return plan / "store"; }

std::string to_json(const std::vector<StepState>& states) {
  Json json = Json::array();
  for (const StepState& state : states) {
    json.push_back({{"stage", stage_name(state.stage)},
                    {"step", state.step},
                    {"is_done", state.is_done},
                    {"parts_there", state.parts_there},
                    {"parts", state.parts}});
  }
  return json_text(json);
}

std::string to_json(const PlanFile& plan) {
  Json json = {{"sightline_plan", kVersion},     {"program", "sightline " + program_version()},
               {"folder", plan.folder.string()}, {"configuration", plan.configuration.string()},
               {"overrides", plan.overrides},    {"model", plan.model.string()},
               {"values", plan.values},          {"recordings", Json::array()}};
  for (const PlannedRecording& recording : plan.recordings) {
    json["recordings"].push_back({{"role", recording.role}, {"digest", recording.digest}});
  }
  return json_text(json);
}

Result<PlanFile> read_plan_file(const std::filesystem::path& plan) {
  const std::filesystem::path file = plan_file_in(plan);
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(file, kLongest));
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("sightline_plan")) {
    return Error{ErrorCode::kMalformedText,
                 "this is not a plan; `sightline cluster plan` writes one", file.string()};
  }
  const Json& version = json["sightline_plan"];
  if (!version.is_number_integer() || version.get<std::int64_t>() != kVersion) {
    return Error{ErrorCode::kFutureVersion,
                 concat("found a plan of version ", json_text(version, -1),
                        ", this program reads version ", kVersion),
                 file.string()};
  }
  Fields fields(json);
  PlanFile read;
  read.folder = fields.text("folder");
  read.configuration = fields.text("configuration");
  read.model = fields.text("model");
  read.values = fields.text("values");
  for (const Json& override_text : fields.list("overrides")) {
    if (override_text.is_string()) {
      read.overrides.push_back(override_text.get<std::string>());
    } else {
      fields.miss("overrides");
    }
  }
  for (const Json& recording : fields.list("recordings")) {
    Fields of_recording(recording);
    read.recordings.push_back({of_recording.text("role"), of_recording.text("digest")});
    if (!of_recording.missing().empty()) fields.miss("recordings." + of_recording.missing());
  }
  if (fields.missing().empty()) return read;
  return Error{ErrorCode::kMissingKey,
               concat("'", fields.missing(), "' is missing or has a wrong value"), file.string()};
}

std::vector<std::string> engine_names() { return {"slurm", "make", "snakemake"}; }

std::string engine_script(std::string_view engine, const EngineJob& job) {
  if (engine == "slurm") return slurm_script(job);
  if (engine == "make") return make_script(job);
  return snakemake_script(job);
}

}  // namespace sightline
