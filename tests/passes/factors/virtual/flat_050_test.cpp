#include "passes/factors/virtual/flat_050.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

constexpr std::size_t kNoShift = kShiftCount / 2;

TEST(Flat050, IsTheBestOfTheTwelveShiftsOfAboutHalfAMetre) {
  ShiftGrid score{};
  score[kNoShift] = 4.0;
  score[kNoShift + 1] = 3.9;                       // 0.25 m: too near
  score[kNoShift + kShiftsPerAxis + 1] = 3.8;      // 0.35 m: too near
  score[kNoShift + 2 * kShiftsPerAxis + 2] = 3.7;  // 0.71 m: too far
  score[kNoShift - 2] = 2.0;                       // 0.5 m
  score[kNoShift - 2 * kShiftsPerAxis + 1] = 3.0;  // 0.56 m
  EXPECT_EQ(flat_050(score), 0.75);
}

TEST(Flat050, MayExceedOne) {
  ShiftGrid score{};
  score[kNoShift] = 1.0;
  score[kNoShift + 2] = 2.0;
  EXPECT_EQ(flat_050(score), 2.0);
}

TEST(Flat050, IsOneWhereNothingScores) { EXPECT_EQ(flat_050(ShiftGrid{}), 1.0); }

}  // namespace
}  // namespace sightline
