#include "formats/base/thread_limit.h"

#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <set>
#include <thread>

#include "formats/base/machine.h"
#include "formats/base/parallel.h"

namespace sightline {
namespace {

// Threads that took part in work which lets others begin too.
std::size_t threads_of_work() {
  std::mutex mutex;
  std::set<std::thread::id> threads;
  parallel_for(64, 0, [&](std::size_t) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard<std::mutex> lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  return threads.size();
}

TEST(ThreadLimit, HoldsForWorkWithoutANumberOfThreads) {
  const int all = usable_threads();
  EXPECT_GE(all, 1);
  EXPECT_LE(all, usable_processors());
  {
    const ThreadLimit one(1);
    EXPECT_EQ(usable_threads(), 1);
    EXPECT_EQ(threads_each(0, 1), 1);
    EXPECT_EQ(threads_of_work(), 1U);
    {
      const ThreadLimit three(3);
      EXPECT_EQ(usable_threads(), 3);
    }
    EXPECT_EQ(usable_threads(), 1);
  }
  EXPECT_EQ(usable_threads(), all);
  const ThreadLimit none(0);
  EXPECT_EQ(usable_threads(), all);
}

}  // namespace
}  // namespace sightline
