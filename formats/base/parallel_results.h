#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/base/result.h"

namespace sightline {

// All body(i), in order of i whatever the threads did; or the error of the first i that has one.
// Every body is called, up to `threads` at a time (0: all there are).
template <class T>
Result<std::vector<T>> parallel_results(std::size_t count, int threads,
                                        const std::function<Result<T>(std::size_t)>& body) {
  std::vector<std::optional<Result<T>>> made(count);
  parallel_for(count, threads, [&](std::size_t i) { made[i] = body(i); });
  std::vector<T> values;
  values.reserve(count);
  for (std::optional<Result<T>>& one : made) {
    if (!*one) return one->error();
    values.push_back(**std::move(one));
  }
  return values;
}

}  // namespace sightline
