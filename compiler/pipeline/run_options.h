#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "passes/pass/pass_context.h"

namespace sightline {

struct RunOptions {
  int threads = 0;  // 0 = all there are
  std::uint64_t seed = 1;
  std::filesystem::path cache_directory;  // empty: nothing is kept
  std::vector<std::string> print_after;   // names of steps
  std::string stop_after;                 // name of a step; empty: to the end
  // Else what is wanted is made and stored, and let go after its last use like all that is not.
  bool keeps_wanted = true;
  // Where several processes share the work: what this one takes first.
  WorkShare share;
  // Whether a step may run; what may not has to be in the cache. Empty: all may.
  std::function<bool(const std::string& step)> may_run;
};

}  // namespace sightline
