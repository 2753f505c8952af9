#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/hash.h"

namespace sightline {

// Which parts of the work of a pass this process takes first, where several processes are at the
// same work: the `number`-th of `of` runs of parts.
struct WorkShare {
  std::size_t number = 0;  // below `of`
  std::size_t of = 1;
};

// A part of the work of a pass (work_in_parts.h).
struct PartName {
  std::size_t number = 0;
  // Of all that decides its bytes besides the pass, its options and the seed; nothing: any of the
  // pass's inputs may.
  std::optional<Digest> content = std::nullopt;
};

// All that a pass may know besides its options and inputs: no files, no clock, no environment.
// The functions may be empty; all are safe to call from several threads.
struct PassContext {
  int threads = 1;
  std::uint64_t seed = 1;
  // Units done so far, of how many.
  std::function<void(std::size_t done, std::size_t total)> progress_sink;
  // One sentence that asks for something: what is wrong or doubtful, and what to do.
  std::function<void(const std::string& message)> warning_sink;
  // One sentence that asks for nothing: counts, and what was used.
  std::function<void(const std::string& message)> information_sink;
  // Finished parts of a long pass, so that an interrupted run goes on where it stopped, several
  // processes may share the work, and what a change does not reach is found again. What was saved
  // comes back to the same pass with the same options and the same content, if it was kept.
  std::function<std::optional<std::vector<std::byte>>(const PartName& part)> saved_part;
  std::function<void(const PartName& part, std::span<const std::byte> bytes)> part_sink;
  // What there is to make, before the first of it. A pass whose parts hang on others that it made
  // before reports both in turn; running it again reports the same lists in the same order.
  std::function<void(std::span<const PartName> parts)> parts_sink;
  WorkShare share;

  void progress(std::size_t done, std::size_t total) const {
    if (progress_sink) progress_sink(done, total);
  }
  void warn(const std::string& message) const {
    if (warning_sink) warning_sink(message);
  }
  void inform(const std::string& message) const {
    if (information_sink) information_sink(message);
  }
};

// The threads and the seed of a context, without its sinks: for work whose progress and warnings
// are those of another pass, or were given before.
inline PassContext quiet(const PassContext& ctx) {
  PassContext without_sinks;
  without_sinks.threads = ctx.threads;
  without_sinks.seed = ctx.seed;
  return without_sinks;
}

}  // namespace sightline
