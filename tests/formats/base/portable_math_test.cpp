#include "formats/base/portable_math.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeast = std::numeric_limits<double>::denorm_min();
constexpr int kTrials = 200000;

// Distance of `found` from the exact value, in units of the last place of the latter as a double.
double off_ulp(double found, long double exact) {
  const double nearest = static_cast<double>(exact);
  const double next = std::nextafter(std::abs(nearest), kInfinity);
  const long double ulp = static_cast<long double>(next) - std::abs(nearest);
  return static_cast<double>(std::abs(static_cast<long double>(found) - exact) / ulp);
}

double any_size(Random& random, double low, double high) {
  const double size = std::exp2(random.uniform(low, high));
  return random.below(2) == 0 ? size : -size;
}

bool is_same(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

TEST(PortableMath, KnowsTheQuarterTurns) {
  EXPECT_EQ(portable_sin_cos(0.0).sin, 0.0);
  EXPECT_EQ(portable_sin_cos(0.0).cos, 1.0);
  EXPECT_EQ(portable_sin_cos(0.5 * std::numbers::pi).sin, 1.0);
  EXPECT_EQ(portable_sin_cos(std::numbers::pi).cos, -1.0);
  EXPECT_EQ(portable_atan2(0.0, 0.0), 0.0);
  EXPECT_EQ(portable_atan2(0.0, -2.0), std::numbers::pi);
  EXPECT_EQ(portable_atan2(3.0, 0.0), 0.5 * std::numbers::pi);
  EXPECT_EQ(portable_atan2(-3.0, 3.0), -0.25 * std::numbers::pi);
  EXPECT_EQ(portable_asin(1.0), 0.5 * std::numbers::pi);
  EXPECT_EQ(portable_acos(-1.0), std::numbers::pi);
  EXPECT_EQ(portable_log(1.0), 0.0);
  EXPECT_EQ(portable_log(2.0), std::numbers::ln2);
  EXPECT_EQ(portable_exp(0.0), 1.0);
  EXPECT_DOUBLE_EQ(portable_exp(1.0), std::numbers::e);
  EXPECT_EQ(portable_hypot(3.0, -4.0), 5.0);
}

TEST(PortableMath, SineAndCosineStayWithinAUnitInTheLastPlace) {
  Random random(3);
  for (int trial = 0; trial < kTrials; ++trial) {
    const double angle_rad = trial % 2 == 0 ? random.uniform(-1e5, 1e5) : any_size(random, -60, 16);
    const SinCos at = portable_sin_cos(angle_rad);
    ASSERT_LE(off_ulp(at.sin, std::sin(static_cast<long double>(angle_rad))), 1.0) << angle_rad;
    ASSERT_LE(off_ulp(at.cos, std::cos(static_cast<long double>(angle_rad))), 1.0) << angle_rad;
  }
}

TEST(PortableMath, SineAndCosineOfHugeAnglesLoseLittle) {
  Random random(4);
  for (int trial = 0; trial < 1000; ++trial) {
    const double angle_rad = any_size(random, 17, 40);
    const SinCos at = portable_sin_cos(angle_rad);
    ASSERT_NEAR(at.sin, std::sin(angle_rad), 4e-17 * std::abs(angle_rad)) << angle_rad;
    ASSERT_NEAR(at.cos, std::cos(angle_rad), 4e-17 * std::abs(angle_rad)) << angle_rad;
  }
  const SinCos largest = portable_sin_cos(std::numeric_limits<double>::max());
  EXPECT_NEAR(portable_hypot(largest.sin, largest.cos), 1.0, 1e-15);
}

TEST(PortableMath, AtanAsinAndAcosStayWithinTheirBounds) {
  Random random(5);
  for (int trial = 0; trial < kTrials; ++trial) {
    const double y = any_size(random, -20, 20);
    const double x = trial % 2 == 0 ? any_size(random, -20, 20) : random.uniform(-2.0, 2.0) * y;
    ASSERT_LE(off_ulp(portable_atan2(y, x), std::atan2(static_cast<long double>(y), x)), 2.0)
        << y << " " << x;
    const double s = trial % 2 == 0 ? random.uniform(-1.0, 1.0) : any_size(random, -60, 0);
    ASSERT_LE(off_ulp(portable_asin(s), std::asin(static_cast<long double>(s))), 3.0) << s;
    ASSERT_LE(off_ulp(portable_acos(s), std::acos(static_cast<long double>(s))), 3.0) << s;
  }
}

TEST(PortableMath, ExpAndLogStayWithinTheirBounds) {
  Random random(6);
  for (int trial = 0; trial < kTrials; ++trial) {
    const double x = trial % 2 == 0 ? random.uniform(-746.0, 709.78) : any_size(random, -60, 5);
    ASSERT_LE(off_ulp(portable_exp(x), std::exp(static_cast<long double>(x))), 1.0) << x;
    const double size =
        trial % 2 == 0 ? std::abs(any_size(random, -1074, 1024)) : random.uniform(0.5, 2.0);
    const long double exact = size;
    ASSERT_LE(off_ulp(portable_log(size), std::log(exact)), 1.0) << size;
    ASSERT_LE(off_ulp(portable_log2(size), std::log2(exact)), 3.0) << size;
  }
  for (int exponent = -1074; exponent < 1024; ++exponent) {
    ASSERT_EQ(portable_log2(std::ldexp(1.0, exponent)), exponent);
  }
}

TEST(PortableMath, HypotStaysWithinItsBound) {
  Random random(7);
  for (int trial = 0; trial < kTrials; ++trial) {
    const double x = any_size(random, -20, 20);
    const double y = any_size(random, -20, 20);
    ASSERT_LE(off_ulp(portable_hypot(x, y), std::hypot(static_cast<long double>(x), y)), 2.0);
  }
}

TEST(PortableMath, GivesWhatTheCLibraryGivesForSpecialValues) {
  const double nan = std::nan("");
  const double most = std::numeric_limits<double>::max();
  const std::vector<double> values = {0.0,    -0.0,    kInfinity, -kInfinity, nan,  kLeast, -kLeast,
                                      1e-310, -1e-310, 2.0,       -2.0,       most, -most};
  for (const double y : values) {
    for (const double x : values) {
      const double found = portable_atan2(y, x);
      const double expected = std::atan2(y, x);
      EXPECT_TRUE(is_same(found, expected) || std::abs(found - expected) <= 4e-16 * std::abs(found))
          << y << " " << x << ": " << found << " " << expected;
      EXPECT_TRUE(std::isnan(found) || std::signbit(found) == std::signbit(expected));
    }
    EXPECT_TRUE(is_same(portable_exp(y), std::exp(y)) || std::abs(y) == 2.0) << y;
    EXPECT_TRUE(std::isnan(portable_log(y)) == std::isnan(std::log(y))) << y;
    EXPECT_TRUE(std::isinf(std::log(y)) ? portable_log(y) == std::log(y) : true) << y;
    EXPECT_TRUE(std::isinf(std::log2(y)) ? portable_log2(y) == std::log2(y) : true) << y;
    EXPECT_EQ(std::isnan(portable_asin(y)), std::isnan(std::asin(y))) << y;
    EXPECT_EQ(std::isnan(portable_acos(y)), std::isnan(std::acos(y))) << y;
  }
  for (const double tiny : {0.0, -0.0, kLeast, -kLeast, 1e-310}) {
    EXPECT_TRUE(is_same(portable_sin_cos(tiny).sin, tiny)) << tiny;
    EXPECT_TRUE(is_same(portable_asin(tiny), tiny)) << tiny;
    EXPECT_EQ(portable_sin_cos(tiny).cos, 1.0) << tiny;
  }
  for (const double bad : {nan, kInfinity, -kInfinity}) {
    EXPECT_TRUE(std::isnan(portable_sin_cos(bad).sin));
    EXPECT_TRUE(std::isnan(portable_sin_cos(bad).cos));
  }
}

TEST(PortableMath, ReachesTheseBits) {
  Random random(8);
  std::uint64_t bits = 0;
  const auto add = [&](double value) { bits = mix(bits, std::bit_cast<std::uint64_t>(value)); };
  for (int trial = 0; trial < 20000; ++trial) {
    const double x = random.uniform(-20.0, 20.0);
    const double y = random.uniform(-1.0, 1.0);
    const SinCos at = portable_sin_cos(x);
    for (const double value :
         {at.sin, at.cos, portable_atan2(y, x), portable_asin(y), portable_acos(y), portable_exp(x),
          portable_log(std::abs(x)), portable_log2(std::abs(x)), portable_hypot(x, y)}) {
      add(value);
    }
  }
  EXPECT_EQ(bits, 1850670739426050841U);
}

}  // namespace
}  // namespace sightline
