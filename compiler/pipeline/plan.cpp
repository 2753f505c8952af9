#include "compiler/pipeline/plan.h"

#include <algorithm>
#include <limits>
#include <set>

#include "formats/base/files/stored_bytes.h"

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

void PassSettings::set(std::string_view pass, OptionField& field) const {
  const std::map<std::string, std::string>* values = &shared;
  if (!field.is_shared) {
    const auto section = own.find(std::string(pass));
    if (section == own.end()) return;
    values = &section->second;
  }
  const auto value = values->find(field.name);
  if (value == values->end()) return;
  const Result<void> is_set = set_from_text(field, value->second);
  SIGHTLINE_CHECK(is_set.has_value());
}

Result<std::shared_ptr<const void>> in_form(const ArtifactSet::Entry& entry,
                                            const ArtifactType& form) {
  if (entry.type == &form) return entry.value;
  SIGHTLINE_CHECK(entry.type->name == form.name && entry.type->write && form.read);
  // Forms are of the same bytes.
  constexpr std::size_t kMostOfForm = std::size_t{4} << 20;
  GrowingBytes bytes(entry.type->is_form ? kMostOfForm : std::numeric_limits<std::size_t>::max());
  SIGHTLINE_TRY(entry.type->write(
      entry.value.get(), [&](std::span<const std::byte> piece) { return bytes.append(piece); }));
  return form.read(bytes.take());
}

}  // namespace sightline
