#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "compiler/pipeline/pass.h"

namespace sightline {

// What happened to one step.
struct StepReport {
  std::string name;
  bool from_cache = false;
  std::string reason;  // why it ran, or "unchanged"
  double wall_s = 0.0;
  double cpu_s = 0.0;
  double peak_memory_mib = 0.0;  // of the process while the step ran
  std::vector<std::string> warnings;
};

// What a person or a program may want to see while a pipeline runs; any may be empty.
struct RunObserver {
  std::function<void(std::size_t step, std::size_t steps, const std::string& name)> started;
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::function<void(const std::string& pass, const std::string& message)> warning;
  std::function<void(const StepReport&)> finished;
  std::function<void(const std::string& pass, const Table&)> printed;  // --print-after
};

struct RunOptions {
  int threads = 0;  // 0 = all there are
  std::uint64_t seed = 1;
  std::filesystem::path cache_directory;  // empty: nothing is kept
  std::vector<std::string> print_after;   // names of steps
  std::string stop_after;                 // name of a step; empty: to the end
};

// Artifacts by name, immutable and shared.
class ArtifactSet {
 public:
  // An artifact from outside, with a key that names its content.
  template <class X>
  void provide(const std::string& name, X artifact, const Digest& key) {
    put(name, {&artifact_type<X>(), std::make_shared<const X>(std::move(artifact)), key});
  }
  [[nodiscard]] bool has(const std::string& name) const { return entries_.contains(name); }
  // The artifact, which must be there and of this type.
  template <class X>
  [[nodiscard]] const X& get(const std::string& name) const {
    const Entry& entry = entries_.at(name);
    SIGHTLINE_CHECK(entry.type == &artifact_type<X>());
    return *static_cast<const X*>(entry.value.get());
  }

  struct Entry {
    const ArtifactType* type = nullptr;
    std::shared_ptr<const void> value;
    Digest key{};
  };
  [[nodiscard]] const Entry& entry(const std::string& name) const { return entries_.at(name); }
  void put(const std::string& name, Entry entry) { entries_[name] = std::move(entry); }

 private:
  std::map<std::string, Entry> entries_;
};

// Runs the steps in their order: a step is loaded from the cache when pass, version, options, seed
// and the keys of its inputs are those of an earlier run, else it runs, its output is validated and
// stored. Adds what was made to `artifacts` and appends to `reports`. The first failure ends the
// run; its Error names the pass in `place` unless the pass named a place itself.
// Errors: unknown-pass (print_after or stop_after), what passes and the cache return.
Result<void> run_pipeline(const std::vector<PassStep>& steps, const RunOptions& options,
                          const RunObserver& observer, ArtifactSet& artifacts,
                          std::vector<StepReport>& reports);

}  // namespace sightline
