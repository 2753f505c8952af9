#include "formats/base/parallel.h"

#include <algorithm>

#include "formats/base/thread_limit.h"

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#else
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <utility>
#endif

namespace sightline {
namespace {

#ifdef __SANITIZE_THREAD__

// Threads that ThreadSanitizer knows: TBB is not instrumented, and what a task reads that was
// written before it began would be reported as a race.
void run_on_threads(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) body(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      failure = std::current_exception();
      next = count;
    }
  };
  const auto wanted = static_cast<std::size_t>(threads_each(threads, 1));
  std::vector<std::thread> helpers;
  for (std::size_t i = 1; i < std::min(wanted, count); ++i) helpers.emplace_back(work);
  work();
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

#else

// Threads of the arena that runs what this thread is at; 0: none of ours.
thread_local int arena_threads = 0;

class WithinArena {
 public:
  explicit WithinArena(int threads) : before_(std::exchange(arena_threads, threads)) {}
  ~WithinArena() { arena_threads = before_; }
  WithinArena(const WithinArena&) = delete;
  WithinArena& operator=(const WithinArena&) = delete;

 private:
  int before_;
};

void run_on_threads(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const int wanted = threads_each(threads, 1);
  const bool is_within = wanted <= arena_threads;
  const int size = is_within ? arena_threads : wanted;
  const auto run = [&] {
    oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      const WithinArena within(size);
      body(i);
    });
  };
  // Nested work is shared too. It is isolated: a waiting thread that began other work might hold a
  // lock that this work needs.
  if (is_within) return oneapi::tbb::this_task_arena::isolate(run);
  oneapi::tbb::task_arena(size).execute(run);
}

#endif

}  // namespace

void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  if (threads != 1 && count > 1) return run_on_threads(count, threads, body);
  for (std::size_t i = 0; i < count; ++i) body(i);
}

int threads_each(int threads, std::size_t count) {
  const int all = threads > 0 ? threads : usable_threads();
  return std::max(1, all / static_cast<int>(std::clamp<std::size_t>(count, 1, 1024)));
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
