#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/map/compile_to_map.h"
#include "compiler/driver/pipelines.h"
#include "compiler/work/shared_work.h"

namespace sightline {
namespace {

struct LinkFlags {
  std::string plan;
  std::string output;
  bool is_forced = false;
  RunFlags run;
};

Result<void> link(const LinkFlags& flags) {
  const IfExists if_exists = flags.is_forced ? IfExists::kReplace : IfExists::kRefuse;
  SIGHTLINE_TRY(try_output(flags.output, if_exists));
  const std::string output = std::filesystem::absolute(flags.output).string();
  SIGHTLINE_ASSIGN(SharedWork work, open_work(flags.plan));
  SIGHTLINE_TRY(try_poses_output(output, if_exists, work.compile));
  const Plan& plan = work.compile.plan;
  RunOptions options = options_in(work, Stage::kLink);
  options.threads = flags.run.threads;
  SIGHTLINE_ASSIGN(const std::vector<StepReport> reports,
                   run_steps(plan, reported_artifacts(work.compile), flags.run, options,
                             work.config, work.artifacts));
  SIGHTLINE_TRY(
      write_compiled(output, if_exists, work.config, work.compile, work.artifacts, reports));
  return flags.run.is_quiet ? Result<void>() : print_summary(work.compile, work.artifacts);
}

}  // namespace

Verb link_verb() {
  const auto flags = std::make_shared<LinkFlags>();
  Verb verb;
  verb.name = "link";
  verb.summary = "Make the map of a plan whose work is finished";
  verb.details =
      "The map, its provenance and what is printed are those of `sightline compile` with the same "
      "configuration. Where something is missing, exit status 75 and the list.";
  verb.examples = {"sightline link plan/ -o city.slmap"};
  verb.positionals = {
      {.name = "PLAN", .help = "The folder that `sightline plan` wrote", .target = &flags->plan}};
  verb.flags = {required_output_flag(flags->output, "The map to write (.slmap)"),
                force_flag(flags->is_forced),
                threads_flag(flags->run.threads),
                time_passes_flag(flags->run.time_passes),
                json_progress_flag(flags->run.json_progress),
                quiet_flag(flags->run.is_quiet)};
  verb.run = [flags] { return exit_status_of(link(*flags)); };
  return verb;
}

}  // namespace sightline
