#pragma once

#include <map>
#include <memory>
#include <utility>

#include "compiler/pipeline/plan.h"
#include "formats/base/hash.h"

namespace sightline {

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
