#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "compiler/config/expected_cost.h"
#include "compiler/driver/pipelines.h"
#include "compiler/work/shared_work.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/hash.h"

namespace sightline {
namespace {

struct PlanFlags {
  std::string configuration;
  std::vector<std::string> overrides;
  std::string output;
  std::string model;
  std::string engine;
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
std::string cost_text(const SharedWork& work) {
  RunOptions options = options_in(work, Stage::kLink);
  options.threads = 1;
  return to_text(expected_cost(work.compile.plan, reported_artifacts(work.compile), options,
                               work.config, work.artifacts),
                 work.store);
}

std::string next_steps(const PlanFlags& flags) {
  const std::string shares = std::to_string(flags.shares);
  std::string text = "\nNext, one stage after the other, its shares on any machines:\n";
  for (const Stage stage : kWorkStages) {
    text += concat("  sightline work ", flags.output, " --stage ", stage_name(stage));
    if (is_shared(stage)) text += concat(" --share K/", shares, "    # K = 1 to ", shares);
    text += "\n";
  }
  return concat(text, "  sightline link ", flags.output, " -o map.slmap\n");
}

Result<void> plan(const PlanFlags& flags) {
  SIGHTLINE_ASSIGN(const NewPlan made,
                   new_plan(flags.output, flags.configuration, flags.overrides, flags.model));
  SIGHTLINE_TRY(write_plan(flags, made.file));
  if (flags.engine.empty()) {
    print_text(cost_text(made.work) + next_steps(flags));
    return {};
  }
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
  verb.name = "plan";
  verb.summary = "Plan a compile that many processes or machines do together";
  verb.details =
      "Writes a folder that names the compile, and into which `work` puts what it finished. All "
      "machines must see that folder and the recordings under the same paths. There is no "
      "scheduler: `work` is given a stage and a share by whatever runs it, and every stage may "
      "begin when the one before has ended. --emit prints a script for an engine.\n\n"
      "`link` makes the map, which has the same bytes as that of `compile`.";
  verb.examples = {
      "sightline plan city.yaml -o plan/",
      "sightline plan city.yaml -o plan/ --emit slurm --shares 64 > city.sh && bash city.sh "
      "--mem=2G",
      "sightline plan city.yaml -o plan/ --emit make --shares 8 > city.mk && make -f city.mk -j8",
      "sightline plan city.yaml -o plan/ --emit snakemake --shares 8 > Snakefile && snakemake "
      "--cores 8"};
  verb.positionals = {{.name = "CONFIG",
                       .help = "YAML configuration (schemas/config.schema.json)",
                       .target = &flags->configuration}};
  verb.flags = {
      required_output_flag(flags->output, "The folder of the plan"),
      force_flag(flags->is_forced),
      {.names = "--set",
       .value = "KEY=VALUE",
       .help = "Override one value of the configuration: section.key=value",
       .target = &flags->overrides},
      {.names = "--model",
       .value = "FILE",
       .help = "Take the error model of this file (.slmodel) or map (.slmap), as `compile` does",
       .target = &flags->model},
      {.names = "--emit",
       .value = "ENGINE",
       .help = "Print a script that does all the work with this engine",
       .target = &flags->engine,
       .choices = engine_names()},
      {.names = "--shares",
       .value = "N",
       .help = "Processes that share a stage, in the script",
       .target = &flags->shares,
       .minimum = 1,
       .maximum = 100000},
      {.names = "--map",
       .value = "FILE",
       .help = "The map that the script links; else map.slmap in the folder of the plan",
       .target = &flags->map}};
  verb.run = [flags] { return exit_status_of(plan(*flags)); };
  return verb;
}

}  // namespace sightline
