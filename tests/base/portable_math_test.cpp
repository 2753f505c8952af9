#include "compiler/base/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "compiler/base/random.h"

namespace sightline {
namespace {

TEST(PortableMath, KnowsTheQuarterTurns) {
  EXPECT_EQ(portable_sin_cos(0.0).sin, 0.0);
  EXPECT_EQ(portable_sin_cos(0.0).cos, 1.0);
  EXPECT_EQ(portable_sin_cos(0.5 * std::numbers::pi).sin, 1.0);
  EXPECT_EQ(portable_sin_cos(std::numbers::pi).cos, -1.0);
  EXPECT_EQ(portable_atan2(0.0, 0.0), 0.0);
  EXPECT_EQ(portable_atan2(0.0, -2.0), std::numbers::pi);
  EXPECT_EQ(portable_atan2(3.0, 0.0), 0.5 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(portable_atan2(-3.0, 3.0), -0.25 * std::numbers::pi);
  EXPECT_EQ(portable_log(1.0), 0.0);
  EXPECT_DOUBLE_EQ(portable_log(2.0), std::numbers::ln2);
}

TEST(PortableMath, AgreesWithTheCLibraryToAFewUnitsInTheLastPlace) {
  Random random(3);
  for (int trial = 0; trial < 200000; ++trial) {
    const double angle_rad = random.uniform(-1.0, 1.0) * (trial % 2 == 0 ? 7.0 : 1e5);
    const SinCos at = portable_sin_cos(angle_rad);
    ASSERT_NEAR(at.sin, std::sin(angle_rad), 4e-16) << angle_rad;
    ASSERT_NEAR(at.cos, std::cos(angle_rad), 4e-16) << angle_rad;
    const double x = random.uniform(-2.0, 2.0);
    const double y = random.uniform(-2.0, 2.0) * (trial % 3 == 0 ? 1e-6 : 1.0);
    ASSERT_NEAR(portable_atan2(y, x), std::atan2(y, x), 1e-15) << y << " " << x;
    const double positive = std::exp(random.uniform(-300.0, 300.0));
    ASSERT_NEAR(portable_log(positive), std::log(positive),
                1e-15 * (1.0 + std::abs(std::log(positive))));
  }
}

TEST(PortableMath, KeepsTheRelativeAccuracyOfSmallAngles) {
  for (double angle_rad = 1e-300; angle_rad < 0.7; angle_rad *= 3.7) {
    EXPECT_NEAR(portable_sin_cos(angle_rad).sin / std::sin(angle_rad), 1.0, 4e-16);
    EXPECT_NEAR(portable_atan2(angle_rad, 1.0) / std::atan(angle_rad), 1.0, 6e-16);
  }
}

}  // namespace
}  // namespace sightline
