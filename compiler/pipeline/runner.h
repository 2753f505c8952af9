#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/pipeline/plan.h"
#include "compiler/pipeline/schedule.h"

namespace sightline {

// The reason of a step whose output is not in the cache, and which no step that runs takes.
inline constexpr std::string_view kNotNeeded = "not needed";

// What a cache that cannot be written means for a run, and what to do.
std::string cannot_store_text(const Error& error);

// What happened to one step.
struct StepReport {
  std::string name;
  bool from_cache = false;  // or not needed
  std::string reason;       // why it ran, "unchanged", or kNotNeeded
  double wall_s = 0.0;
  double cpu_s = 0.0;
  double peak_memory_mib = 0.0;  // of the process while the step ran
  std::vector<std::string> warnings;
};

// What a person or a program may want to see while a plan runs; any may be empty.
struct RunObserver {
  std::function<void(std::size_t step, std::size_t steps, const std::string& name)> started;
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::function<void(const std::string& pass, const std::string& message)> warning;
  std::function<void(const std::string& pass, const std::string& message)> information;
  std::function<void(const StepReport&)> finished;
  std::function<void(const std::string& pass, const Table&)> printed;  // --print-after
};

// Makes what is `wanted` (nothing: the output of every step) and not in `artifacts` yet, in the
// order of the plan. A step is loaded from the cache where pass, version, options, seed and input
// keys are those of an earlier run, and what was needed for it alone is not loaded; else it runs,
// and its output is validated and stored. Inputs of the plan must be in `artifacts`, to which the
// wanted is added; the rest is loaded when a step takes it and freed after its last use. `reports`
// gets one for each step that `wanted` depends on, with the warnings of the run that made it. The
// first failure ends the run; its Error names the pass in `place` unless the pass named a place.
// A cache that cannot be written is a warning, once, unless options.must_store.
// Errors: unknown-pass (print_after or stop_after), work-missing (steps that may not run and are
// not in the cache), those of passes and the cache.
Result<void> run_plan(const Plan& plan, const std::vector<AnyWire>& wanted,
                      const RunOptions& options, const RunObserver& observer,
                      ArtifactSet& artifacts, std::vector<StepReport>& reports);

}  // namespace sightline
