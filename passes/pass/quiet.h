#pragma once

#include "passes/pass/pass_context.h"

namespace sightline {

// The threads and the seed of a context, without its sinks: for work whose progress and warnings
// are those of another pass, or were given before.
inline PassContext quiet(const PassContext& ctx) {
  PassContext without_sinks;
  without_sinks.threads = ctx.threads;
  without_sinks.seed = ctx.seed;
  return without_sinks;
}

}  // namespace sightline
