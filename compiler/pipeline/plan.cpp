#include "compiler/pipeline/plan.h"

#include <algorithm>
#include <set>

namespace sightline {

std::size_t Plan::add_artifact(std::string name, const ArtifactType& type) {
  SIGHTLINE_CHECK(std::ranges::find(artifacts_, name, &PlannedArtifact::name) == artifacts_.end());
  artifacts_.push_back({std::move(name), &type});
  return artifacts_.size() - 1;
}

void Plan::add_step(PassStep step) {
  SIGHTLINE_CHECK(std::ranges::find(steps_, step.name, &PassStep::name) == steps_.end());
  for (const std::size_t input : step.inputs) {
    SIGHTLINE_CHECK(input < artifacts_.size());
    step.stage = std::max(step.stage, artifacts_[input].stage);
  }
  artifacts_[step.output].stage = step.stage;
  steps_.push_back(std::move(step));
}

std::vector<AnyWire> Plan::made() const {
  std::vector<AnyWire> wires;
  for (const PassStep& step : steps_) wires.push_back({step.output});
  return wires;
}

AnyWire Plan::find(std::string_view name) const {
  for (const AnyWire wire : made()) {
    if (artifact(wire).name == name) return wire;
  }
  return {};
}

bool can_be_kept(const Plan& plan, const PassStep& step) {
  const ArtifactType& type = *plan.artifact({step.output}).type;
  return type.read && (!type.refers_outside || step.reattach);
}

std::vector<std::size_t> steps_for(const Plan& plan, const std::vector<AnyWire>& wanted,
                                   const std::function<bool(AnyWire)>& is_there) {
  std::set<std::size_t> needed;
  for (const AnyWire wire : wanted.empty() ? plan.made() : wanted) needed.insert(wire.index);
  std::vector<std::size_t> steps;
  for (std::size_t i = plan.steps().size(); i-- > 0;) {
    const PassStep& step = plan.steps()[i];
    if (!needed.contains(step.output) || is_there({step.output})) continue;
    needed.insert(step.inputs.begin(), step.inputs.end());
    steps.push_back(i);
  }
  std::ranges::reverse(steps);
  return steps;
}

}  // namespace sightline
