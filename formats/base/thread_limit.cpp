#include "formats/base/thread_limit.h"

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <exception>
#include <future>
#include <thread>
#include <vector>

#include "formats/base/machine.h"

namespace sightline {
namespace {

std::atomic<int> chosen_limit = 0;  // 0: none

// How many of so many the system runs at once, this one among them.
int startable_threads(int wanted) {
  std::promise<void> all_started;
  const std::shared_future<void> go = all_started.get_future().share();
  std::vector<std::thread> started;
  started.reserve(static_cast<std::size_t>(wanted));
  try {
    while (static_cast<int>(started.size()) + 1 < wanted) {
      started.emplace_back([go] { go.wait(); });
    }
  } catch (const std::exception&) {  // no further one
  }
  all_started.set_value();
  for (std::thread& thread : started) thread.join();
  return static_cast<int>(started.size()) + 1;
}

int count_usable_threads() {
  const int processors = usable_processors();
  const double limit = std::ceil(processor_limit().value_or(processors) - 1e-9);
  return startable_threads(std::clamp(static_cast<int>(limit), 1, processors));
}

}  // namespace

int usable_threads() {
  // Counting starts threads, so a limit is read first.
  if (const int limit = chosen_limit; limit > 0) return limit;
  static const int kCount = count_usable_threads();
  return kCount;
}

struct ThreadLimit::Control {
  int before = 0;
  oneapi::tbb::global_control tasks;
};

ThreadLimit::ThreadLimit(int threads) {
  const int most = threads > 0 ? threads : usable_threads();
  control_.reset(new Control{
      chosen_limit.exchange(most),
      {oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(most)}});
}

ThreadLimit::~ThreadLimit() { chosen_limit = control_->before; }

}  // namespace sightline
