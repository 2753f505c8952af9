#include "formats/base/concat.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

namespace sightline {
namespace {

TEST(Concat, JoinsTextsCharactersAndNumbers) {
  const std::string name = "town";
  const std::string_view part = std::string_view("drives").substr(0, 5);
  EXPECT_EQ(concat("map of ", name, ": ", 3, ' ', part, '.'), "map of town: 3 drive.");
  EXPECT_EQ(concat(""), "");
}

TEST(Concat, WritesWholeNumbersOfEveryTypeAsToStringDoes) {
  constexpr auto kLeast = std::numeric_limits<std::int64_t>::min();
  constexpr auto kMost = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(concat(kLeast, " ", kMost), std::to_string(kLeast) + " " + std::to_string(kMost));
  EXPECT_EQ(concat(std::uint8_t{200}, " ", std::int8_t{-5}, " ", std::int16_t{-300}),
            "200 -5 -300");
  EXPECT_EQ(concat(std::size_t{0}, 0L, 0ULL), "000");
}

}  // namespace
}  // namespace sightline
