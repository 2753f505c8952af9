#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "compiler/pipeline/artifact_set.h"
#include "compiler/pipeline/plan.h"
#include "compiler/pipeline/run_options.h"
#include "compiler/pipeline/step_key.h"
#include "compiler/store/cache.h"

namespace sightline {

// One step of a run.
struct Scheduled {
  std::size_t step = 0;
  StepKey key;
  bool is_kept = false;    // its output can be in the cache
  bool is_stored = false;  // it seems to be
  bool is_wanted = false;  // its output stays in memory, if the options say so
  bool is_needed = false;  // by the caller or by a step that runs
  [[nodiscard]] bool runs() const { return is_needed && !is_stored; }
};

// The steps that what is `wanted` depends on, in running order, up to options.stop_after; what is
// to be printed or stopped after is wanted too. Keys are known without running anything.
std::vector<Scheduled> schedule(const Plan& plan, const std::vector<AnyWire>& wanted,
                                const RunOptions& options, const ArtifactSet& artifacts,
                                const ArtifactCache& cache);

// What run_plan() would do with one step.
struct PlannedRun {
  std::size_t step = 0;  // of the plan
  std::string name;
  bool is_in_cache = false;  // or not needed, since what it is needed for is
  bool is_kept = false;      // its output can be kept at all
  Digest key{};
};

// The steps that run_plan() would take, in their order; nothing runs and nothing is written.
std::vector<PlannedRun> planned_runs(const Plan& plan, const std::vector<AnyWire>& wanted,
                                     const RunOptions& options, const ArtifactSet& artifacts);

}  // namespace sightline
