#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/result.h"

// Work on several threads whose result does not depend on how many there are.

namespace sightline {

// Calls body(i) once for each i in [0, count), on up to `threads` threads (0 = all there are).
// The order of calls is not defined: a body writes only to slot i of something made before.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

// result[i] = body(i), in order of i whatever the threads did. T is default constructible.
template <class T>
std::vector<T> parallel_map(std::size_t count, int threads,
                            const std::function<T(std::size_t)>& body) {
  std::vector<T> results(count);
  parallel_for(count, threads, [&](std::size_t i) { results[i] = body(i); });
  return results;
}

// How many threads (of `threads`; 0: all there are) each of `count` pieces of work has that are
// done side by side; at least one.
int threads_each(int threads, std::size_t count);

// Sum by pairwise halving in index order: the same bits for any thread count, rounding error
// O(log n) instead of O(n).
double ordered_sum(std::span<const double> values);

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
