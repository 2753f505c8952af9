#include "formats/base/parallel.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace sightline {

void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  if (threads == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  oneapi::tbb::task_arena arena(threads > 0 ? threads : oneapi::tbb::task_arena::automatic);
  arena.execute(
      [&] { oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { body(i); }); });
}

double ordered_sum(std::span<const double> values) {
  // Below this many, plain order is as exact as it needs to be and much quicker.
  constexpr std::size_t kLeaf = 32;
  if (values.size() <= kLeaf) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum;
  }
  const std::size_t half = values.size() / 2;
  return ordered_sum(values.first(half)) + ordered_sum(values.subspan(half));
}

}  // namespace sightline
