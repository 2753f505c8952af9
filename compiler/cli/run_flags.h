#pragma once

#include <string>
#include <vector>

#include "compiler/cli/verb.h"
#include "compiler/config/compile_config.h"
#include "compiler/pipeline/runner.h"

namespace sightline {

// What every verb that runs passes takes on the command line.
struct RunFlags {
  std::string config_file;
  std::vector<std::string> overrides;  // --set section.key=value
  std::string cache_directory;         // empty: ".sightline-cache" beside the configuration
  bool no_cache = false;
  int threads = 0;
  bool is_quiet = false;
  bool is_verbose = false;
  std::vector<std::string> print_after;
  std::string stop_after;
  bool time_passes = false;
  bool explain = false;
  int json_progress = 0;           // file descriptor; 0: none
  std::string kernel = "fastest";  // hidden: the matcher's inner loop, which changes no result
};

// The positional CONFIG, and the flags, after those that the verb has.
void add_run_flags(Verb& verb, RunFlags& flags);
// The flags alone, for a verb that takes several configurations.
void add_flags_of_every_run(Verb& verb, RunFlags& flags);

// Where artifacts are kept; empty: nowhere.
std::filesystem::path cache_directory(const RunFlags& flags);
RunOptions run_options(const RunFlags& flags, const CompileConfig& config);

// Error: bad-argument where --stop-after would end the run before all that is wanted is made.
Result<void> check_stop(const RunFlags& flags, const Plan& plan,
                        const std::vector<AnyWire>& wanted);
// That --stop-after ended the run, and what was therefore not done ("no map is written"), on
// stderr.
void say_stopped(const RunFlags& flags, const std::string& consequence);

// Runs the steps that make what is wanted (nothing: all) with progress on stderr, then prints
// --explain and --time-passes there.
Result<std::vector<StepReport>> run_steps(const Plan& plan, const std::vector<AnyWire>& wanted,
                                          const RunFlags& flags, const CompileConfig& config,
                                          ArtifactSet& artifacts);
// The same with options of the caller's own.
Result<std::vector<StepReport>> run_steps(const Plan& plan, const std::vector<AnyWire>& wanted,
                                          const RunFlags& flags, const RunOptions& options,
                                          const CompileConfig& config, ArtifactSet& artifacts);

}  // namespace sightline
