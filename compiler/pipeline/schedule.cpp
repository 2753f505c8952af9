#include "compiler/pipeline/schedule.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace sightline {
namespace {

std::optional<std::size_t> step_named(const Plan& plan, const std::string& name) {
  for (std::size_t i = 0; i < plan.steps().size(); ++i) {
    if (plan.steps()[i].name == name) return i;
  }
  return std::nullopt;
}

// What the caller looks at, and what is to be printed or stopped after.
std::vector<AnyWire> all_wanted(const Plan& plan, const std::vector<AnyWire>& wanted,
                                const RunOptions& options) {
  std::vector<AnyWire> all = wanted;
  if (all.empty()) return plan.made();
  std::vector<std::string> names = options.print_after;
  if (!options.stop_after.empty()) names.push_back(options.stop_after);
  for (const std::string& name : names) {
    if (const auto step = step_named(plan, name)) all.push_back({plan.steps()[*step].output});
  }
  return all;
}

}  // namespace

std::vector<Scheduled> schedule(const Plan& plan, const std::vector<AnyWire>& wanted,
                                const RunOptions& options, const ArtifactSet& artifacts,
                                const ArtifactCache& cache) {
  const std::vector<AnyWire> all = all_wanted(plan, wanted, options);
  std::map<std::size_t, Digest> key_of;
  const auto key_of_input = [&](std::size_t artifact) {
    const auto made = key_of.find(artifact);
    return made != key_of.end() ? made->second : artifacts.entry({artifact}).key;
  };
  std::vector<Scheduled> list;
  for (const std::size_t index :
       steps_for(plan, all, [&](AnyWire wire) { return artifacts.has(wire); })) {
    const PassStep& step = plan.steps()[index];
    Scheduled next{index, step_key(plan, step, options.seed, key_of_input)};
    next.is_kept = can_be_kept(plan, step);
    next.is_stored = next.is_kept && cache.has(step.name, next.key.key);
    next.is_wanted = std::ranges::find(all, AnyWire{step.output}) != all.end();
    key_of[step.output] = next.key.key;
    list.push_back(std::move(next));
    if (step.name == options.stop_after) break;
  }
  std::set<std::size_t> needed;
  for (std::size_t i = list.size(); i-- > 0;) {
    const PassStep& step = plan.steps()[list[i].step];
    list[i].is_needed = list[i].is_wanted || needed.contains(step.output);
    // What is loaded takes its inputs only where part of it lies in them.
    if (list[i].runs() || (list[i].is_needed && step.reattach)) {
      needed.insert(step.inputs.begin(), step.inputs.end());
    }
  }
  return list;
}

std::vector<PlannedRun> planned_runs(const Plan& plan, const std::vector<AnyWire>& wanted,
                                     const RunOptions& options, const ArtifactSet& artifacts) {
  const ArtifactCache cache = ArtifactCache::to_look_at(options.cache_directory);
  std::vector<PlannedRun> runs;
  for (const Scheduled& scheduled : schedule(plan, wanted, options, artifacts, cache)) {
    runs.push_back({scheduled.step, plan.steps()[scheduled.step].name, !scheduled.runs(),
                    scheduled.is_kept, scheduled.key.key});
  }
  return runs;
}

}  // namespace sightline
