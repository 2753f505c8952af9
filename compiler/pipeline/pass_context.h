#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace sightline {

// All that a pass may know besides its options and inputs: no files, no clock, no environment.
// The functions may be empty; progress and warn are safe to call from several threads.
struct PassContext {
  int threads = 1;
  std::uint64_t seed = 1;
  // Units done so far, of how many.
  std::function<void(std::size_t done, std::size_t total)> progress_sink;
  // One sentence: what was skipped or doubtful, with counts.
  std::function<void(const std::string& message)> warning_sink;

  void progress(std::size_t done, std::size_t total) const {
    if (progress_sink) progress_sink(done, total);
  }
  void warn(const std::string& message) const {
    if (warning_sink) warning_sink(message);
  }
};

}  // namespace sightline
