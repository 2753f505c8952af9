#include "formats/text/numbers.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Numbers, AreRoundedToTheDecimalsAskedFor) {
  EXPECT_EQ(fixed(1.256, 2), "1.26");
  EXPECT_EQ(fixed(-0.5, 0), "-0");
}

TEST(Numbers, OfSharesAndLengthsHaveOneDecimalOrNone) {
  EXPECT_EQ(in_percent(0.9434), "94.3");
  EXPECT_EQ(percent(0.9434), "94.3 %");
  EXPECT_EQ(whole_percent(0.9434), "94 %");
  EXPECT_EQ(whole_percent(0.125), "13 %");
  EXPECT_EQ(in_centimetres(0.0834), "8.3");
}

}  // namespace
}  // namespace sightline
