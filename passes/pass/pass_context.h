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

// Which parts of the work of a pass this process takes first, where several processes are at the
// same work: the `number`-th of `of` runs of parts.
struct WorkShare {
  std::size_t number = 0;  // below `of`
  std::size_t of = 1;
};

// All that a pass may know besides its options and inputs: no files, no clock, no environment.
// The functions may be empty; all are safe to call from several threads.
struct PassContext {
  int threads = 1;
  std::uint64_t seed = 1;
  // Units done so far, of how many.
  std::function<void(std::size_t done, std::size_t total)> progress_sink;
  // One sentence: what was skipped or doubtful, with counts.
  std::function<void(const std::string& message)> warning_sink;
  // Finished parts of a long pass (work_in_parts.h), so that an interrupted run goes on where it
  // stopped and several processes may share the work. What was saved comes back to the same pass
  // with the same options and inputs, if it was kept.
  std::function<std::optional<std::vector<std::byte>>(std::size_t part)> saved_part;
  std::function<void(std::size_t part, std::span<const std::byte> bytes)> part_sink;
  std::function<void(std::size_t count)> part_count_sink;  // told once, before the first part
  WorkShare share;

  void progress(std::size_t done, std::size_t total) const {
    if (progress_sink) progress_sink(done, total);
  }
  void warn(const std::string& message) const {
    if (warning_sink) warning_sink(message);
  }
};

}  // namespace sightline
