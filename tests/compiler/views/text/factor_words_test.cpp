#include "compiler/views/text/factor_words.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(FactorWords, AreThoseOfTheFactorOrItsName) {
  EXPECT_EQ(factor_words("r_average"), "mean distance of NDs (m)");
  EXPECT_EQ(factor_words("virtual_points"), "points of a virtual scan");
  EXPECT_EQ(factor_words("my_own_factor"), "my_own_factor");
}

}  // namespace
}  // namespace sightline
