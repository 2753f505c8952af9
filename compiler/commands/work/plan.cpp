#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "compiler/config/expected_cost.h"
#include "compiler/driver/pipelines.h"
#include "compiler/work/shared_work.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/hash.h"
#include "formats/base/printable.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

struct PlanFlags {
  std::string configuration;
  std::vector<std::string> overrides;
  std::string output;
  std::string model;
  std::string engine;
  std::string format = "text";
  std::string map;
  int shares = 4;
  bool is_forced = false;
};

// Writing the same plan twice changes nothing; another one needs --force.
Result<void> write_plan(const PlanFlags& flags, const PlanFile& file) {
  const std::filesystem::path path = plan_file_in(flags.output);
  const std::string text = to_json(file);
  const Result<std::string> before = read_text_file(path);
  if (before && *before == text) return {};
  return write_file_atomically(path, text, if_exists(flags.is_forced));
}

// Of all stages together, on one thread.
ExpectedCost cost_of(const SharedWork& work) {
  RunOptions options = options_in(work, Stage::kLink);
  options.threads = 1;
  return expected_cost(work.compile.plan, reported_artifacts(work.compile), options, work.config,
                       work.artifacts);
}

std::string next_steps(const PlanFlags& flags) {
  const std::string shares = std::to_string(flags.shares);
  std::string text = "\nNext, run the stages in this order, their shares on any machines:\n";
  for (const Stage stage : kWorkStages) {
    text += concat("  sightline cluster work ", command_word(flags.output), " --stage ",
                   stage_name(stage));
    if (is_shared(stage)) text += concat(" --share K/", shares, "    # K = 1 to ", shares);
    text += "\n";
  }
  return concat(text, "  sightline cluster link ", command_word(flags.output), " -o map.slmap\n");
}

// What engines read ends at a line end, and the rest of a name would be a command of its own.
Result<void> check_names_of_scripts(const PlanFlags& flags) {
  for (const std::string& name : {std::filesystem::absolute(flags.output).string(), flags.map}) {
    if (one_line(name) == name) continue;
    return Error{ErrorCode::kBadArgument,
                 "a path in a script has no line ends or other control characters; choose another",
                 name};
  }
  return {};
}

Result<void> plan(const PlanFlags& flags) {
  SIGHTLINE_ASSIGN(const NewPlan made,
                   new_plan(flags.output, flags.configuration, flags.overrides, flags.model));
  SIGHTLINE_TRY(write_plan(flags, made.file));
  if (flags.engine.empty()) {
    const ExpectedCost cost = cost_of(made.work);
    if (flags.format == "json") {
      print_data(to_json(cost));
    } else if (verbosity() != Verbosity::kQuiet) {
      print_written(plan_file_in(flags.output));
      print_text(to_text(cost, made.work.store) + next_steps(flags));
    }
    return {};
  }
  SIGHTLINE_TRY(check_names_of_scripts(flags));
  EngineJob job;
  job.program = std::filesystem::read_symlink("/proc/self/exe");
  job.plan = std::filesystem::absolute(flags.output).lexically_normal();
  job.map = flags.map.empty() ? job.plan / "map.slmap" : std::filesystem::absolute(flags.map);
  job.shares = flags.shares;
  job.plan_digest = to_hex(sha256(to_json(made.file))).substr(0, 16);
  print_data(engine_script(flags.engine, job));
  return {};
}

}  // namespace

Verb plan_verb() {
  const auto flags = std::make_shared<PlanFlags>();
  Verb verb;
  verb.name = "cluster plan";
  verb.summary = "Plan a compile that many processes or machines share";
  verb.details =
      "Writes a folder with the plan; `cluster work` stores its results there. All machines must "
      "see this folder and the recordings under the same paths. sightline has no scheduler: an "
      "engine, or a person, starts `cluster work` with a stage and a share. A stage may begin "
      "when the stage before it has ended. --emit prints a script for an engine.\n\n"
      "`cluster link` then makes the map. It has the same bytes as the map of `compile`.";
  verb.examples = {
      "sightline cluster plan city.yaml -o plan/",
      "sightline cluster plan city.yaml -o plan/ --emit slurm --shares 64 > city.sh \\\n"
      "      && bash city.sh --mem=2G",
      "sightline cluster plan city.yaml -o plan/ --emit make --shares 8 > city.mk \\\n"
      "      && make -f city.mk -j8",
      "sightline cluster plan city.yaml -o plan/ --emit snakemake --shares 8 > Snakefile \\\n"
      "      && snakemake --cores 8"};
  verb.positionals = {{.name = "CONFIG",
                       .help = "YAML configuration (schemas/config.schema.json)",
                       .target = &flags->configuration}};
  verb.flags = {
      required_output_flag(flags->output, "The folder of the plan"),
      force_flag(flags->is_forced),
      {.names = "--set",
       .value = "KEY=VALUE",
       .help =
           "Override one value of the configuration: section.key=value; paths are relative to the "
           "current folder, not to the configuration",
       .target = &flags->overrides},
      {.names = "--model",
       .value = "FILE",
       .help = "Use the error model of this file (.slmodel) or map (.slmap), as in `compile`",
       .target = &flags->model},
      {.names = "--emit",
       .value = "ENGINE",
       .help = "Print a script that runs the whole plan with this engine",
       .target = &flags->engine,
       .choices = engine_names()},
      {.names = "--format",
       .value = "FORMAT",
       .help = "Form of the estimated cost; json as schemas/cost.schema.json describes it",
       .target = &flags->format,
       .choices = {"text", "json"},
       .excludes = "--emit"},
      {.names = "--shares",
       .value = "N",
       .help = "Number of processes that share a stage, in the script",
       .target = &flags->shares,
       .minimum = 1,
       .maximum = 100000},
      {.names = "--map",
       .value = "FILE",
       .help = "The map that the script makes; default: map.slmap in the folder of the plan",
       .target = &flags->map}};
  verb.run = [flags] { return exit_status_of(plan(*flags)); };
  return verb;
}

}  // namespace sightline
