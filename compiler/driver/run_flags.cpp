#include "compiler/driver/run_flags.h"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <utility>

#include "compiler/driver/console.h"
#include "compiler/driver/progress_json.h"
#include "passes/matching/kernel_score.h"

namespace sightline {
namespace {

// Error: bad-argument where this processor does not have it.
Result<void> choose_kernel(const std::string& name) {
  MatchKernel kernel = MatchKernel::kFastest;
  if (name == "portable") kernel = MatchKernel::kPortable;
  if (name == "avx2") kernel = MatchKernel::kAvx2;
  if (name == "avx512") kernel = MatchKernel::kAvx512;
  if (!is_supported(kernel)) {
    return Error{ErrorCode::kBadArgument, "this processor does not have " + name, "", "--kernel"};
  }
  replace_fastest_kernel(kernel);
  return {};
}

// JSON on stderr stands there alone; on a descriptor of its own beside what people see.
Result<RunObserver> observer_of(const RunFlags& flags) {
  const RunObserver console = console_observer(flags.is_quiet);
  if (flags.json_progress == 0) return console;
  const Result<void> open = check_progress_descriptor(flags.json_progress);
  if (!open) return open.error();
  RunObserver json = json_observer(flags.json_progress);
  if (flags.json_progress != STDERR_FILENO) return both(console, std::move(json));
  json.printed = console.printed;
  return json;
}

}  // namespace

void add_run_flags(CLI::App& command, RunFlags& flags) {
  command
      .add_option("config", flags.config_file, "YAML configuration (schemas/config.schema.json)")
      ->required();
  add_flags_of_every_run(command, flags);
}

void add_flags_of_every_run(CLI::App& command, RunFlags& flags) {
  command
      .add_option("--set", flags.overrides,
                  "Override one value of the configuration, as section.key=value; repeatable")
      ->take_all();
  command.add_option("--threads", flags.threads, "Threads to use; 0 takes all there are")
      ->check(CLI::Range(0, 1024));
  command.add_option("--cache", flags.cache_directory,
                     "Folder of finished artifacts (default: .sightline-cache beside the "
                     "configuration)");
  command.add_flag("--no-cache", flags.no_cache, "Run every pass and keep nothing");
  command
      .add_option("--print-after", flags.print_after,
                  "Print the result of this pass on stdout, as CSV; repeatable")
      ->allow_extra_args(false);
  command.add_option("--stop-after", flags.stop_after, "End after this pass");
  command.add_flag("--time-passes", flags.time_passes,
                   "Print time and peak memory of each pass on stderr");
  command.add_flag("--explain", flags.explain, "Print why each pass ran or did not, on stderr");
  command.add_flag("--json-progress{2}", flags.json_progress,
                   "Report progress as one JSON object a line, on stderr instead of the lines for "
                   "people, or, as --json-progress=N, on file descriptor N");
  command.add_flag("-q,--quiet", flags.is_quiet,
                   "Only warnings and errors on stderr, and no tables");
  command.add_option("--kernel", flags.kernel)
      ->check(CLI::IsMember({"fastest", "portable", "avx2", "avx512"}))
      ->group("");
}

RunOptions run_options(const RunFlags& flags, const CompileConfig& config) {
  RunOptions options;
  options.threads = flags.threads;
  options.seed = static_cast<std::uint64_t>(config.annotation.seed);
  options.print_after = flags.print_after;
  options.stop_after = flags.stop_after;
  if (flags.no_cache) return options;
  options.cache_directory = flags.cache_directory;
  if (flags.cache_directory.empty()) {
    options.cache_directory =
        std::filesystem::path(flags.config_file).parent_path() / ".sightline-cache";
  }
  return options;
}

Result<std::vector<StepReport>> run_steps(const Plan& plan, const std::vector<AnyWire>& wanted,
                                          const RunFlags& flags, const CompileConfig& config,
                                          ArtifactSet& artifacts) {
  const Result<void> kernel = choose_kernel(flags.kernel);
  if (!kernel) return kernel.error();
  const Result<RunObserver> observer = observer_of(flags);
  if (!observer) return observer.error();
  explain_interruption();
  std::vector<StepReport> reports;
  const Result<void> run = run_plan(plan, wanted, run_options(flags, config), *observer,
                                    artifacts, reports);
  if (flags.explain) std::fputs(explanation(reports).c_str(), stderr);
  if (flags.time_passes) std::fputs(time_table(reports).c_str(), stderr);
  if (!run) return run.error();
  return reports;
}

}  // namespace sightline
