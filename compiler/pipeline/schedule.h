#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "compiler/pipeline/plan.h"
#include "compiler/store/cache.h"
#include "formats/base/hash.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// What decides a step's output, and the name that it gives it. The label of a step, "mapping[2]" of
// "ingest:mapping[2]", decides nothing: a recording that another one was added before keeps its
// keys.
struct StepKey {
  std::string record;  // lines "name = value" that a person can compare
  Digest key{};        // of `way` and of the contents of the inputs, in their order
  Digest way{};        // of the pass and of the record without the inputs: how the step works
};

// `key_of_input`: of an artifact of the plan.
StepKey step_key(const Plan& plan, const PassStep& step, std::uint64_t seed,
                 const std::function<Digest(std::size_t artifact)>& key_of_input);

// Of a part of a step's work: with the content that it names, whatever inputs the step has.
Digest part_key(const StepKey& step, const PartName& part);

// Why a step must run: the first lines in which its record differs from that of the last run.
std::string reason_to_run(const std::string& before, const std::string& now);

struct RunOptions {
  int threads = 0;  // 0 = all there are
  std::uint64_t seed = 1;
  std::filesystem::path cache_directory;  // empty: nothing is kept
  std::vector<std::string> print_after;   // names of steps
  std::string stop_after;                 // name of a step; empty: to the end
  // Else what is wanted is made and stored, and let go after its last use like all that is not.
  bool keeps_wanted = true;
  // Whether the run is of use only through what it stores: then a failure to store ends it. Else it
  // is a warning, the first time, and the run continues.
  bool must_store = false;
  // Where several processes share the work: what this one takes first.
  WorkShare share;
  // Whether a step may run; what may not has to be in the cache. Empty: all may.
  std::function<bool(const std::string& step)> may_run;
};

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
