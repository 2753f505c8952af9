#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/try_output.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/map/compile_to_map.h"
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
  const Plan& plan = work.compile.plan;
  RunOptions options = run_options(flags.run, work.config);
  options.cache_directory = work.store;
  options.keeps_parts = true;
  options.may_run = may_run_in(plan, Stage::kLink);
  SIGHTLINE_ASSIGN(
      const std::vector<StepReport> reports,
      run_steps(plan, told_of(work.compile), flags.run, options, work.config, work.artifacts));
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
                {.names = "--threads",
                 .value = "N",
                 .help = "Threads to use; 0 takes all there are",
                 .target = &flags->run.threads,
                 .minimum = 0,
                 .maximum = 1024},
                {.names = "--time-passes",
                 .help = "Print time and peak memory of each pass on stderr",
                 .target = &flags->run.time_passes},
                quiet_flag(flags->run.is_quiet)};
  verb.run = [flags] { return exit_status_of(link(*flags)); };
  return verb;
}

}  // namespace sightline
