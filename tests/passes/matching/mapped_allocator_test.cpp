#include "passes/matching/grid/mapped_allocator.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace sightline {
namespace {

TEST(MappedAllocator, HoldsShortAndLongArraysAsAnyVectorDoes) {
  for (const std::size_t count : {1UL, 1000UL, 300'000UL, 1'000'000UL}) {
    MappedVector<std::uint64_t> numbers;
    for (std::size_t i = 0; i < count; ++i) numbers.push_back(i * i);
    const MappedVector<std::uint64_t> copy = numbers;
    numbers = {};
    ASSERT_EQ(copy.size(), count);
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(copy[i], i * i);
  }
}

TEST(MappedAllocator, ALongArrayBeginsOnALargePage) {
  const MappedVector<std::uint64_t> numbers(400'000);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(numbers.data()) % kHugePage_bytes, 0u);
}

}  // namespace
}  // namespace sightline
