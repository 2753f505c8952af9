#include "compiler/cli/run_flags.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/config/expected_cost.h"
#include "passes/matching/kernel_score.h"

namespace sightline {
namespace {

// Error: bad-argument where this processor does not have it.
Result<void> choose_kernel(const std::string& name) {
  MatchKernel kernel = MatchKernel::kFastest;
  for (const MatchKernel each :
       {MatchKernel::kPortable, MatchKernel::kAvx2, MatchKernel::kAvx512}) {
    if (name == kernel_name(each)) kernel = each;
  }
  if (!is_supported(kernel)) {
    return Error{ErrorCode::kBadArgument, "this processor does not have " + name, "", "--kernel"};
  }
  replace_fastest_kernel(kernel);
  return {};
}

// JSON on stderr replaces the text there; on another descriptor it is added.
Result<RunObserver> observer_of(const RunFlags& flags, const std::vector<ExpectedTime>& expected) {
  const RunObserver console = console_observer(flags.is_quiet     ? Verbosity::kQuiet
                                               : flags.is_verbose ? Verbosity::kVerbose
                                                                  : Verbosity::kNormal,
                                               expected);
  if (flags.json_progress == 0) return console;
  SIGHTLINE_TRY(check_progress_descriptor(flags.json_progress));
  RunObserver json = json_observer(flags.json_progress, expected);
  if (flags.json_progress != STDERR_FILENO) return both(console, std::move(json));
  json.printed = console.printed;
  return json;
}

}  // namespace

void add_run_flags(Verb& verb, RunFlags& flags) {
  verb.positionals.push_back({.name = "CONFIG",
                              .help = "YAML configuration (schemas/config.schema.json)",
                              .target = &flags.config_file});
  add_flags_of_every_run(verb, flags);
}

void add_flags_of_every_run(Verb& verb, RunFlags& flags) {
  const std::vector<Flag> of_every_run = {
      {.names = "--set",
       .value = "KEY=VALUE",
       .help =
           "Override one value of the configuration: section.key=value; paths are relative to the "
           "current folder, not to the configuration",
       .target = &flags.overrides},
      threads_flag(flags.threads),
      {.names = "--cache",
       .value = "FOLDER",
       .help = "Folder of the cache; default: .sightline-cache beside the configuration",
       .target = &flags.cache_directory},
      {.names = "--no-cache",
       .help = "Run every pass, and neither read nor write a cache",
       .target = &flags.no_cache},
      {.names = "--print-after",
       .value = "PASS",
       .help = "Print the result of this pass on stdout, as CSV",
       .target = &flags.print_after},
      {.names = "--stop-after",
       .value = "PASS",
       .help = "Stop after this pass",
       .target = &flags.stop_after},
      time_passes_flag(flags.time_passes),
      {.names = "--explain",
       .help = "Print why each pass ran or did not, on stderr",
       .target = &flags.explain},
      json_progress_flag(flags.json_progress),
      quiet_flag(flags.is_quiet),
      verbose_flag(flags.is_verbose),
      {.names = "--kernel",
       .value = "NAME",
       .help = "Inner loop of the matcher; all give the same result",
       .target = &flags.kernel,
       .choices = {"fastest", "portable", "avx2", "avx512"},
       .is_hidden = true}};
  verb.flags.insert(verb.flags.end(), of_every_run.begin(), of_every_run.end());
}

std::filesystem::path cache_directory(const RunFlags& flags) {
  if (flags.no_cache) return {};
  if (!flags.cache_directory.empty()) return flags.cache_directory;
  return std::filesystem::path(flags.config_file).parent_path() / ".sightline-cache";
}

RunOptions run_options(const RunFlags& flags, const CompileConfig& config) {
  RunOptions options;
  options.threads = flags.threads;
  options.seed = static_cast<std::uint64_t>(config.annotation.seed);
  options.print_after = flags.print_after;
  options.stop_after = flags.stop_after;
  options.cache_directory = cache_directory(flags);
  return options;
}

Result<void> check_stop(const RunFlags& flags, const Plan& plan,
                        const std::vector<AnyWire>& wanted) {
  const std::vector<PassStep>& steps = plan.steps();
  const auto last = std::ranges::find(steps, flags.stop_after, &PassStep::name);
  if (last == steps.end()) return {};
  for (auto later = last + 1; later != steps.end(); ++later) {
    const AnyWire output{later->output};
    if (std::ranges::find(wanted, output) == wanted.end()) continue;
    return Error{ErrorCode::kBadArgument,
                 concat("--stop-after ", flags.stop_after, ": '", plan.artifact(output).name,
                        "' is made later, by ", later->name),
                 "", ""};
  }
  return {};
}

void say_stopped(const RunFlags& flags, const std::string& consequence) {
  if (flags.is_quiet || flags.json_progress == STDERR_FILENO) return;
  std::fputs((concat("stopped after ", flags.stop_after, ": ", consequence, "\n")).c_str(), stderr);
}

Result<std::vector<StepReport>> run_steps(const Plan& plan, const std::vector<AnyWire>& wanted,
                                          const RunFlags& flags, const CompileConfig& config,
                                          ArtifactSet& artifacts) {
  return run_steps(plan, wanted, flags, run_options(flags, config), config, artifacts);
}

Result<std::vector<StepReport>> run_steps(const Plan& plan, const std::vector<AnyWire>& wanted,
                                          const RunFlags& flags, const RunOptions& options,
                                          const CompileConfig& config, ArtifactSet& artifacts) {
  SIGHTLINE_TRY(choose_kernel(flags.kernel));
  std::vector<ExpectedTime> expected;
  for (const ExpectedStep& step : expected_cost(plan, wanted, options, config, artifacts).steps) {
    expected.push_back({step.wall_s, step.counted});
  }
  SIGHTLINE_ASSIGN(const RunObserver observer, observer_of(flags, expected));
  for (const std::string& note : config.notes) observer.warning("configuration", note);
  explain_interruption(!options.cache_directory.empty());
  std::vector<StepReport> reports;
  const Result<void> run = run_plan(plan, wanted, options, observer, artifacts, reports);
  if (flags.explain) std::fputs(explanation(reports).c_str(), stderr);
  if (flags.time_passes) std::fputs(time_table(reports).c_str(), stderr);
  if (!run) return run.error();
  return reports;
}

}  // namespace sightline
