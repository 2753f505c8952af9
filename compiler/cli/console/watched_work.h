#pragma once

#include <functional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Work of a verb that is no step of a plan.
struct WatchedWork {
  std::string name;  // as that of a pass
  int threads = 0;
  int json_progress = 0;              // file descriptor; 0: none
  std::vector<std::string> warnings;  // that are known before
};

// Does the work with progress, warnings and the time taken reported as of one pass. Errors: those
// of the work and of check_progress_descriptor().
Result<void> do_watched(const WatchedWork& work,
                        const std::function<Result<void>(PassContext& ctx)>& body);

}  // namespace sightline
