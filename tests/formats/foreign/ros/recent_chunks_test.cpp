#include "formats/foreign/ros/files/bag_chunks.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>

#include "formats/base/random.h"

namespace sightline {
namespace {

using Bytes = std::vector<std::byte>;
constexpr std::size_t kChunkSize = 100;

// Chunks whose bytes are their number, with a count of how often each was unpacked.
struct Packed {
  RecentChunks recent;
  std::array<std::atomic<int>, 100> times{};

  Result<Bytes> read(std::size_t chunk, std::size_t offset = 10, std::size_t size = 20) {
    return recent.read({chunk, kChunkSize, offset, size}, [&]() -> Result<Bytes> {
      ++times.at(chunk);
      return Bytes(kChunkSize, static_cast<std::byte>(chunk));
    });
  }
};

TEST(RecentChunks, ThreadsThatReadDifferentPartsUnpackEachChunkOnce) {
  Packed packed;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 8; ++t) {
    threads.emplace_back([&packed, t] {
      for (std::size_t chunk = 10 * t; chunk < 10 * t + 5; ++chunk) {
        for (std::size_t scan = 0; scan < 5; ++scan) {
          EXPECT_EQ(*packed.read(chunk, 20 * scan), Bytes(20, static_cast<std::byte>(chunk)));
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t chunk = 0; chunk < 80; ++chunk) {
    EXPECT_EQ(packed.times.at(chunk), chunk % 10 < 5 ? 1 : 0) << chunk;
  }
}

TEST(RecentChunks, WhatWasNotReadForLongestMakesRoom) {
  Packed packed{RecentChunks(3 * kChunkSize)};
  for (const std::size_t chunk : {1U, 2U, 3U, 1U, 4U, 1U, 3U, 4U}) {
    ASSERT_TRUE(packed.read(chunk));
  }
  EXPECT_EQ(packed.times[1], 1);
  EXPECT_EQ(packed.times[3], 1);
  EXPECT_EQ(packed.times[4], 1);
  ASSERT_TRUE(packed.read(2));
  EXPECT_EQ(packed.times[2], 2);
}

TEST(RecentChunks, AChunkLargerThanAllIsKeptUntilTheNext) {
  Packed packed{RecentChunks(kChunkSize / 2)};
  for (const std::size_t chunk : {1U, 1U, 1U, 2U, 1U}) ASSERT_TRUE(packed.read(chunk));
  EXPECT_EQ(packed.times[1], 2);
}

TEST(RecentChunks, GivesTheBytesOfAnyOrderOfReads) {
  Random random(1);
  Packed packed{RecentChunks(5 * kChunkSize)};
  for (int read = 0; read < 2000; ++read) {
    const std::size_t chunk = random.below(20);
    const std::size_t offset = random.below(kChunkSize + 1);
    const std::size_t size = random.below(kChunkSize - offset + 1);
    EXPECT_EQ(*packed.read(chunk, offset, size), Bytes(size, static_cast<std::byte>(chunk)));
  }
}

TEST(RecentChunks, AChunkThatDidNotUnpackIsTriedAgain) {
  RecentChunks recent;
  int times = 0;
  const auto unpack = [&]() -> Result<Bytes> {
    if (++times == 1) return Error{ErrorCode::kCannotRead, "gone", "", ""};
    return Bytes(kChunkSize, std::byte{7});
  };
  EXPECT_EQ(recent.read({1, kChunkSize, 0, 1}, unpack).error().code, ErrorCode::kCannotRead);
  EXPECT_EQ(*recent.read({1, kChunkSize, 0, 1}, unpack), Bytes(1, std::byte{7}));
}

}  // namespace
}  // namespace sightline
