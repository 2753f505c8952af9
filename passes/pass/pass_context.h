#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sightline {

// All that a pass may know besides its options and inputs: no files, no clock, no environment.
// The functions may be empty; all are safe to call from several threads.
struct PassContext {
  int threads = 1;
  std::uint64_t seed = 1;
  // Units done so far, of how many.
  std::function<void(std::size_t done, std::size_t total)> progress_sink;
  // One sentence: what was skipped or doubtful, with counts.
  std::function<void(const std::string& message)> warning_sink;
  // Finished parts of a long pass, so that an interrupted run goes on where it stopped. What was
  // saved comes back in a later run of the same pass with the same options and inputs, if it was
  // kept; the pass must give the same output either way.
  std::function<std::optional<std::vector<std::byte>>(std::size_t part)> saved_part;
  std::function<void(std::size_t part, std::span<const std::byte> bytes)> part_sink;

  void progress(std::size_t done, std::size_t total) const {
    if (progress_sink) progress_sink(done, total);
  }
  [[nodiscard]] std::optional<std::vector<std::byte>> load_part(std::size_t part) const {
    return saved_part ? saved_part(part) : std::nullopt;
  }
  void save_part(std::size_t part, std::span<const std::byte> bytes) const {
    if (part_sink) part_sink(part, bytes);
  }
  void warn(const std::string& message) const {
    if (warning_sink) warning_sink(message);
  }
};

}  // namespace sightline
