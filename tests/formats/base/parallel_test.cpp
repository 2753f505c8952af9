#include "formats/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "formats/base/random.h"

namespace sightline {
namespace {

TEST(ParallelFor, CallsEachIndexOnceForAnyThreadCount) {
  for (const int threads : {0, 1, 2, 7}) {
    std::vector<std::atomic<int>> calls(1000);
    parallel_for(calls.size(), threads, [&](std::size_t i) { ++calls[i]; });
    for (const std::atomic<int>& count : calls) EXPECT_EQ(count.load(), 1);
  }
}

TEST(ParallelFor, WorkWithinWorkTakesNoMoreThreads) {
  for (const int inner : {0, 1, 3}) {
    std::atomic<int> calls = 0;
    std::atomic<int> at_work = 0;
    std::atomic<int> most = 0;
    parallel_for(5, 3, [&](std::size_t) {
      parallel_for(20, std::min(3, threads_each(inner, 1)), [&](std::size_t) {
        const int now = ++at_work;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        std::this_thread::sleep_for(std::chrono::microseconds(100));
        ++calls;
        --at_work;
      });
    });
    EXPECT_EQ(calls.load(), 100);
    EXPECT_LE(most.load(), 3);
  }
}

TEST(ParallelFor, FailsWithinWorkAsItDoesAlone) {
  const auto fail = [](std::size_t i) {
    if (i == 7) throw std::runtime_error("seven");
  };
  EXPECT_THROW(parallel_for(3, 2, [&](std::size_t) { parallel_for(10, 2, fail); }),
               std::runtime_error);
}

TEST(ThreadsEach, SharesThemOutAndLeavesNoneWithoutOne) {
  EXPECT_EQ(threads_each(8, 1), 8);
  EXPECT_EQ(threads_each(8, 3), 2);
  EXPECT_EQ(threads_each(2, 100), 1);
  EXPECT_EQ(threads_each(4, 0), 4);
  EXPECT_GE(threads_each(0, 1), 1);
}

TEST(ParallelMap, KeepsTheOrderOfItsIndices) {
  const std::vector<std::size_t> squares =
      parallel_map<std::size_t>(100, 3, [](std::size_t i) { return i * i; });
  for (std::size_t i = 0; i < squares.size(); ++i) EXPECT_EQ(squares[i], i * i);
}

TEST(OrderedSum, IsCloserToTheTruthThanAddingInARow) {
  std::vector<double> values;
  Random random(1);
  long double truth = 0.0L;
  double in_a_row = 0.0;
  for (int i = 0; i < 1'000'000; ++i) {
    values.push_back(random.uniform(0.0, 1.0) * std::pow(10.0, random.uniform(-6.0, 6.0)));
    truth += static_cast<long double>(values.back());
    in_a_row += values.back();
  }
  const double exact = static_cast<double>(truth);
  EXPECT_LE(std::abs(ordered_sum(values) - exact), std::abs(in_a_row - exact));
  EXPECT_NEAR(ordered_sum(values) / exact, 1.0, 1e-15);
  EXPECT_EQ(ordered_sum({}), 0.0);
}

}  // namespace
}  // namespace sightline
