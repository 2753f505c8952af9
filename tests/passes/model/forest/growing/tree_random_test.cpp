#include "passes/model/forest/growing/tree_random.h"

#include <dlib/rand.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace sightline {
namespace {

constexpr std::size_t kLargest = std::numeric_limits<long long>::max();

// Many numbers, of ranges of all sizes: the largest reject about every second number.
void expect_numbers_of_dlib(std::uint64_t seed) {
  TreeRandom random(seed);
  dlib::rand judge(std::to_string(seed) + "/0");
  for (std::size_t i = 0; i < 5000; ++i) {
    const std::size_t end = kLargest >> i % 63;
    const std::size_t begin = i % 7 == 0 ? end / 3 : 0;
    const auto wanted =
        judge.get_integer_in_range(static_cast<long long>(begin), static_cast<long long>(end));
    ASSERT_EQ(random.in_range(begin, end), static_cast<std::size_t>(wanted)) << "number " << i;
  }
}

TEST(TreeRandom, DrawsTheNumbersOfDlib) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    for (const std::uint64_t seed : {i, i * 0x9e3779b97f4a7c15U}) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      expect_numbers_of_dlib(seed);
    }
  }
}

TEST(TreeRandom, OfAnEmptyRangeDrawsNothing) {
  TreeRandom random(1);
  TreeRandom other(1);
  EXPECT_EQ(random.in_range(5, 5), 5U);
  EXPECT_EQ(random.in_range(0, 1000), other.in_range(0, 1000));
}

}  // namespace
}  // namespace sightline
