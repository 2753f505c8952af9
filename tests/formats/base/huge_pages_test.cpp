#include "formats/base/huge_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace sightline {
namespace {

TEST(HugePages, HoldWhatAnyVectorHolds) {
  constexpr std::size_t kLong = std::size_t{3} << 20;
  HugeVector<std::uint8_t> bytes;
  std::vector<std::uint8_t> expected;
  for (std::size_t i = 0; i < kLong; ++i) {  // grows from small pages into large ones
    bytes.push_back(static_cast<std::uint8_t>(i * 31));
    expected.push_back(static_cast<std::uint8_t>(i * 31));
  }
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), expected.begin(), expected.end()));
  const HugeVector<std::uint8_t> copy = bytes;
  bytes.clear();
  bytes.shrink_to_fit();
  EXPECT_EQ(copy.size(), kLong);
  EXPECT_EQ(copy.back(), expected.back());
}

TEST(HugePages, LongArraysBeginAtALargePage) {
  struct alignas(32) Record {
    float values[72];
  };
  const HugeVector<Record> records(100'000);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(records.data()) % (std::uintptr_t{2} << 20), 0U);
  const HugeVector<Record> few(3);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(few.data()) % alignof(Record), 0U);
}

}  // namespace
}  // namespace sightline
