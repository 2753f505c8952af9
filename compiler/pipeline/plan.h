#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/pipeline/step.h"
#include "formats/base/check.h"
#include "formats/base/hash.h"
#include "passes/pass/pass.h"

// A plan says which passes run on which artifacts. Artifacts are handed on as typed wires, so that
// a pass that is given another artifact than its signature takes does not compile:
//
//   Plan plan(settings);
//   const Wire<SurfacePoints> points = plan.input<SurfacePoints>("points");
//   const Wire<NdtMap> ndt = plan.run(kBuildNdt, points);
//
// A parameter `const X&` of a pass takes a Wire<X>, `const X*` a Maybe<X>, and `Many<X>` a list of
// wires. A wire is of the artifact; a pass may take and make it in another form (step.h).

namespace sightline {

// Values for the options of passes, as texts that were checked when they were read. What is not
// named keeps the default of the pass.
struct PassSettings {
  std::map<std::string, std::string> shared;  // by field: for every pass with a shared field of it
  std::map<std::string, std::map<std::string, std::string>> own;  // by pass, by field

  // The options of a pass by these settings.
  template <class Output, class Options, class... Parameters>
  [[nodiscard]] Options options(const Pass<Output, Options, Parameters...>& pass) const {
    Options options{};
    for (OptionField& field : option_fields(options)) set(pass.name, field);
    return options;
  }

 private:
  void set(std::string_view pass, OptionField& field) const;
};

inline constexpr std::size_t kNotConnected = static_cast<std::size_t>(-1);

// An artifact of a plan, of whatever type.
struct AnyWire {
  std::size_t index = kNotConnected;
  friend bool operator==(const AnyWire&, const AnyWire&) = default;
};

// An artifact of type X. Only a plan makes wires that are connected.
template <class X>
class Wire {
 public:
  Wire() = default;
  [[nodiscard]] bool is_connected() const { return index_ != kNotConnected; }
  [[nodiscard]] AnyWire any() const { return {index_}; }
  operator AnyWire() const { return any(); }
  friend bool operator==(const Wire&, const Wire&) = default;

 private:
  friend class Plan;
  explicit Wire(std::size_t index) : index_(index) {}
  std::size_t index_ = kNotConnected;
};

// An artifact of type X, or none: a wire that need not be connected.
template <class X>
class Maybe {
 public:
  Maybe() = default;
  Maybe(Wire<X> wire) : wire_(wire) {}
  [[nodiscard]] Wire<X> wire() const { return wire_; }

 private:
  Wire<X> wire_;
};

// What a plan connects to a parameter of a pass, and the artifacts that these are.
template <class Parameter>
struct WiresFor;
template <class X>
struct WiresFor<const X&> {
  using Type = Wire<ArtifactOf<X>>;
  static std::vector<AnyWire> all(const Type& wire) { return {wire}; }
};
template <class X>
struct WiresFor<const X*> {
  using Type = Maybe<ArtifactOf<X>>;
  static std::vector<AnyWire> all(const Type& maybe) {
    if (!maybe.wire().is_connected()) return {};
    return {maybe.wire()};
  }
};
template <class X>
struct WiresFor<Many<X>> {
  using Type = std::vector<Wire<ArtifactOf<X>>>;
  static std::vector<AnyWire> all(const Type& wires) { return {wires.begin(), wires.end()}; }
};
template <class Parameter>
using WiresOf = typename WiresFor<Parameter>::Type;

// What is known of an artifact before it is made.
struct PlannedArtifact {
  std::string name;  // unique in the plan, as `dump --what` takes it: "nds", "mapping/measured"
  const ArtifactType* type = nullptr;
  Stage stage = Stage::kDrives;  // in which it is made
};

// The options of one pass that a configuration may set. The fields point into `options`.
struct PassSection {
  std::string name;
  std::string help;
  std::shared_ptr<void> options;
  std::vector<OptionField> fields;  // without those that all passes share
};

class Plan {
 public:
  explicit Plan(PassSettings settings = {}) : settings_(std::move(settings)) {}

  // An artifact that is provided from outside before the plan runs.
  template <class X>
  Wire<X> input(std::string name) {
    return Wire<X>(add_artifact(std::move(name), artifact_type<X>()));
  }

  // The options that the settings give to a pass.
  template <class Output, class Options, class... Parameters>
  [[nodiscard]] Options options(const Pass<Output, Options, Parameters...>& pass) const {
    return settings_.options(pass);
  }

  // A step that runs `pass` with the options of the settings.
  template <class Output, class Options, class... Parameters>
  Wire<ArtifactOf<Output>> run(const Pass<Output, Options, Parameters...>& pass,
                               const WiresOf<Parameters>&... inputs) {
    return run_as("", pass, options(pass), inputs...);
  }

  // A step "pass:label" that makes the artifact "label/table", with options of its own.
  template <class Output, class Options, class... Parameters>
  Wire<ArtifactOf<Output>> run_as(std::string_view label,
                                  const Pass<Output, Options, Parameters...>& pass,
                                  const std::type_identity_t<Options>& options,
                                  const WiresOf<Parameters>&... inputs) {
    add_section<Options>(pass.name, pass.help);
    const std::vector<std::vector<AnyWire>> taken = {WiresFor<Parameters>::all(inputs)...};
    std::vector<std::size_t> counts;
    for (const std::vector<AnyWire>& wires : taken) counts.push_back(wires.size());
    PassStep step = make_step(pass, options, counts);
    for (const std::vector<AnyWire>& wires : taken) {
      for (const AnyWire wire : wires) step.inputs.push_back(wire.index);
    }
    step.name = label.empty() ? std::string(pass.name) : concat(pass.name, ":", label);
    step.output =
        add_artifact(label.empty() ? std::string(pass.table) : concat(label, "/", pass.table),
                     artifact_type<ArtifactOf<Output>>());
    const std::size_t output = step.output;
    add_step(std::move(step));
    return Wire<ArtifactOf<Output>>(output);
  }

  [[nodiscard]] const std::vector<PassStep>& steps() const { return steps_; }
  [[nodiscard]] const PlannedArtifact& artifact(AnyWire wire) const {
    return artifacts_[wire.index];
  }
  // Artifacts that steps make, in running order.
  [[nodiscard]] std::vector<AnyWire> made() const;
  // The artifact of that name that a step makes; not connected where there is none.
  [[nodiscard]] AnyWire find(std::string_view name) const;
  // Sections of the passes that have options of their own, in running order, each once. The values
  // are the defaults.
  [[nodiscard]] const std::vector<PassSection>& sections() const { return sections_; }

 private:
  template <class Options>
  void add_section(std::string_view name, std::string_view help) {
    for (const PassSection& section : sections_) {
      if (section.name == name) return;
    }
    const std::shared_ptr<Options> options = std::make_shared<Options>();
    PassSection section{std::string(name), std::string(help), options, option_fields(*options)};
    std::erase_if(section.fields, [](const OptionField& field) { return field.is_shared; });
    if (!section.fields.empty()) sections_.push_back(std::move(section));
  }
  std::size_t add_artifact(std::string name, const ArtifactType& type);
  // No step runs in an earlier stage than those that make its inputs.
  void add_step(PassStep step);

  PassSettings settings_;
  std::vector<PlannedArtifact> artifacts_;
  std::vector<PassStep> steps_;
  std::vector<PassSection> sections_;
};

// Whether the output of a step can be loaded again once it was written: what lies outside an
// artifact has to come back from the inputs of its step.
bool can_be_kept(const Plan& plan, const PassStep& step);

// Indices of the steps that make `wanted` where the artifacts for which `is_there` holds are there
// already, in running order. Nothing wanted: all that is not there.
std::vector<std::size_t> steps_for(const Plan& plan, const std::vector<AnyWire>& wanted,
                                   const std::function<bool(AnyWire)>& is_there);

// Artifacts of one plan, immutable and shared.
class ArtifactSet {
 public:
  struct Entry {
    const ArtifactType* type = nullptr;  // in the form that it is in
    std::shared_ptr<const void> value;
    Digest key{};  // of all that decided the content
  };

  // An artifact from outside, with a key that names its content.
  template <class X>
  void provide(Wire<X> wire, X artifact, const Digest& key) {
    put(wire, {&artifact_type<X>(), std::make_shared<const X>(std::move(artifact)), key});
  }
  // The same, keyed by its encoding.
  template <class X>
  void provide(Wire<X> wire, X artifact) {
    const Digest key = sha256(to_bytes(artifact));
    provide(wire, std::move(artifact), key);
  }
  // An artifact of another plan.
  template <class X>
  void share(Wire<X> wire, const ArtifactSet& others, Wire<X> of_others) {
    put(wire, others.entry(of_others));
  }

  [[nodiscard]] bool has(AnyWire wire) const { return entries_.contains(wire.index); }
  // The artifact, which must be there and whole.
  template <class X>
  [[nodiscard]] const X& get(Wire<X> wire) const {
    const Entry& found = entry(wire);
    SIGHTLINE_CHECK(found.type == &artifact_type<X>());
    return *static_cast<const X*>(found.value.get());
  }
  [[nodiscard]] const Entry& entry(AnyWire wire) const {
    const auto found = entries_.find(wire.index);
    SIGHTLINE_CHECK(found != entries_.end());
    return found->second;
  }
  void remove(AnyWire wire) { entries_.erase(wire.index); }
  void put(AnyWire wire, Entry entry) { entries_[wire.index] = std::move(entry); }

 private:
  std::map<std::size_t, Entry> entries_;  // by the index of the wire
};

// The artifact in a form of it. What is whole stays in memory; what is not, and what is made of it,
// may lie in a temporary file. Errors: cannot-read, disk-full, cannot-write.
Result<std::shared_ptr<const void>> in_form(const ArtifactSet::Entry& entry,
                                            const ArtifactType& form);

}  // namespace sightline
