#include "formats/base/portable_math.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

// Argument reduction and minimax polynomials after fdlibm (Sun Microsystems, 1993), whose
// coefficients are used; evaluated in one fixed order, without a table and without a fused
// multiply-add.

namespace sightline {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPiLow = 0x1.1a62633145c07p-53;  // pi - kPi
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ln 2 = high + low, high with so few bits that products with an exponent are exact.
constexpr double kLn2High = 0x1.62e42feep-1;
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;

// c[0] + x c[1] + ... by Horner's rule.
template <std::size_t N>
double polynomial(const double (&c)[N], double x) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = c[i] + x * sum;
  return sum;
}

// The nearest whole number of at most 2^51 in size: beside a number so large no fraction fits.
double whole_of(double x) {
  constexpr double kLarge = 0x1.8p52;
  return (x + kLarge) - kLarge;
}

// An angle as x + tail with |x| <= pi / 4, the tail being what rounding x lost.
struct Reduced {
  double x = 0.0;
  double tail = 0.0;
};

double sin_of(const Reduced& angle) {
  constexpr double kFirst = -1.66666666666666324348e-01;
  constexpr double kRest[] = {8.33333333332248946124e-03, -1.98412698298579493134e-04,
                              2.75573137070700676789e-06, -2.50507602534068634195e-08,
                              1.58969099521155010221e-10};
  const double x2 = angle.x * angle.x;
  const double x3 = x2 * angle.x;
  const double rest = polynomial(kRest, x2);
  return angle.x - ((x2 * (0.5 * angle.tail - x3 * rest) - angle.tail) - x3 * kFirst);
}

double cos_of(const Reduced& angle) {
  constexpr double kSeries[] = {4.16666666666666019037e-02, -1.38888888888741095749e-03,
                                2.48015872894767294178e-05, -2.75573143513906633035e-07,
                                2.08757232129817482790e-09, -1.13596475577881948265e-11};
  const double x2 = angle.x * angle.x;
  const double series = x2 * polynomial(kSeries, x2);
  const double half = 0.5 * x2;
  const double sum = 1.0 - half;
  return sum + (((1.0 - sum) - half) + (x2 * series - angle.x * angle.tail));
}

// 0 <= x, or infinite: the angle is one of four known ones and that of a small tangent.
double atan_of(double x) {
  constexpr double kSeries[] = {
      3.33333333333329318027e-01,  -1.99999999998764832476e-01, 1.42857142725034663711e-01,
      -1.11111104054623557880e-01, 9.09088713343650656196e-02,  -7.69187620504482999495e-02,
      6.66107313738753120669e-02,  -5.83357013379057348645e-02, 4.97687799461593236017e-02,
      -3.65315727442169155270e-02, 1.62858201153657823623e-02};
  double known = 0.0;
  double low = 0.0;  // what the double of the known angle leaves out
  double t = x;
  if (x >= 2.4375) {
    known = 0.5 * kPi;
    low = 0.5 * kPiLow;
    t = -1.0 / x;
  } else if (x >= 1.1875) {
    known = 9.82793723247329054082e-01;  // atan 1.5
    low = 1.39033110312309984516e-17;
    t = (x - 1.5) / (1.0 + 1.5 * x);
  } else if (x >= 0.6875) {
    known = 0.25 * kPi;
    low = 0.25 * kPiLow;
    t = (x - 1.0) / (1.0 + x);
  } else if (x >= 0.4375) {
    known = 4.63647609000806093515e-01;  // atan 0.5
    low = 2.26987774529616870924e-17;
    t = (2.0 * x - 1.0) / (2.0 + x);
  }
  const double t2 = t * t;
  const double bend = t * (t2 * polynomial(kSeries, t2));
  return known == 0.0 ? t - bend : known - ((bend - low) - t);
}

// x = 2^exponent * (1 + fraction), 1 + fraction from sqrt(1/2) to sqrt(2). x is positive and
// finite.
struct Parts {
  int exponent = 0;
  double fraction = 0.0;
};

Parts parts_of(double x) {
  constexpr std::int64_t kRootOfHalf = 0x3fe6a09e667f3bcd;  // the bits of sqrt(1/2)
  const bool is_subnormal = x < std::numeric_limits<double>::min();
  const auto bits = std::bit_cast<std::int64_t>(is_subnormal ? x * 0x1p54 : x);
  const std::int64_t exponent = (bits - kRootOfHalf) >> 52;
  const double mantissa = std::bit_cast<double>(bits - exponent * (std::int64_t{1} << 52));
  return {static_cast<int>(exponent) - (is_subnormal ? 54 : 0), mantissa - 1.0};
}

// What log(1 + f) is beside f - f^2 / 2, with s = f / (2 + f): s (f^2 / 2 + series in s^2).
double log_rest(double f) {
  constexpr double kSeries[] = {6.666666666666735130e-01, 3.999999999940941908e-01,
                                2.857142874366239149e-01, 2.222219843214978396e-01,
                                1.818357216161805012e-01, 1.531383769920937332e-01,
                                1.479819860511658591e-01};
  const double s = f / (2.0 + f);
  const double s2 = s * s;
  return s * (0.5 * f * f + s2 * polynomial(kSeries, s2));
}

double log_of_special(double x) {
  if (x == 0.0) return -kInfinity;
  return x > 0.0 ? x : kNan;  // infinite, or nan
}

bool is_ordinary(double x) { return x > 0.0 && x < kInfinity; }

double power_of_two(int exponent) {  // of a normal number
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

}  // namespace

SinCos portable_sin_cos(double angle_rad) {
  // pi / 2 in three parts; the first two have so few bits that whole multiples are exact.
  constexpr double kHigh = 0x1.921fb544p+0;
  constexpr double kMiddle = 0x1.0b4611a6p-34;
  constexpr double kLow = 0x1.3198a2e037073p-69;
  constexpr double kFarthest_rad = 1e5;
  if (!(std::abs(angle_rad) < kInfinity)) return {kNan, kNan};
  if (std::abs(angle_rad) > kFarthest_rad) angle_rad = std::remainder(angle_rad, 2.0 * kPi);
  const double turns = whole_of(angle_rad * (2.0 * std::numbers::inv_pi));
  const double first = angle_rad - turns * kHigh;  // exact
  const double middle = turns * kMiddle;           // exact
  const double second = first - middle;
  const double lost = ((first - second) - middle) - turns * kLow;
  Reduced rest{second + lost, 0.0};
  rest.tail = (second - rest.x) + lost;
  const double s = angle_rad == 0.0 ? angle_rad : sin_of(rest);  // keeps -0
  const double c = cos_of(rest);
  switch (static_cast<long long>(turns) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double portable_atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNan;
  const double run = std::abs(x);
  const double rise = std::abs(y);
  double angle_rad = 0.0;
  if (rise == kInfinity && run == kInfinity) {
    angle_rad = 0.25 * kPi;
  } else if (rise != 0.0) {
    angle_rad = atan_of(rise / run);
  }
  if (std::signbit(x)) angle_rad = kPi - (angle_rad - kPiLow);
  return std::copysign(angle_rad, y);
}

double portable_asin(double x) {
  if (!(std::abs(x) < 0.5)) return portable_atan2(x, std::sqrt((1.0 - x) * (1.0 + x)));
  constexpr double kAbove[] = {1.66666666666666657415e-01, -3.25565818622400915405e-01,
                               2.01212532134862925881e-01, -4.00555345006794114027e-02,
                               7.91534994289814532176e-04, 3.47933107596021167570e-05};
  constexpr double kBelow[] = {1.0, -2.40339491173441421878e+00, 2.02094576023350569471e+00,
                               -6.88283971605453293030e-01, 7.70381505559019352791e-02};
  const double x2 = x * x;
  return x + x * (x2 * polynomial(kAbove, x2) / polynomial(kBelow, x2));
}

double portable_acos(double x) { return portable_atan2(std::sqrt((1.0 - x) * (1.0 + x)), x); }

double portable_exp(double x) {
  constexpr double kSeries[] = {1.66666666666666019037e-01, -2.77777777770155933842e-03,
                                6.61375632143793436117e-05, -1.65339022054652515390e-06,
                                4.13813679705723846039e-08};
  if (!(x > -746.0)) return std::isnan(x) ? x : 0.0;
  if (x > 710.0) return kInfinity;
  // x = n ln 2 + high - low, at most 0.35 in size beside n.
  const double n = whole_of(x * std::numbers::log2e);
  const double high = x - n * kLn2High;  // exact
  const double low = n * kLn2Low;
  const double rest = high - low;
  const double rest2 = rest * rest;
  const double c = rest - rest2 * polynomial(kSeries, rest2);
  const double result = 1.0 - ((low - (rest * c) / (2.0 - c)) - high);
  const int exponent = static_cast<int>(n);
  if (exponent > -1021 && exponent < 1024) return result * power_of_two(exponent);
  // In two steps, of which the second one alone rounds: to a subnormal, or to infinity.
  const int half = exponent / 2;
  return result * power_of_two(half) * power_of_two(exponent - half);
}

double portable_log(double x) {
  if (!is_ordinary(x)) return log_of_special(x);
  const auto [exponent, f] = parts_of(x);
  const double k = exponent;
  return k * kLn2High - ((0.5 * f * f - (log_rest(f) + k * kLn2Low)) - f);
}

double portable_log2(double x) {
  if (!is_ordinary(x)) return log_of_special(x);
  const auto [exponent, f] = parts_of(x);
  const double log = f - (0.5 * f * f - log_rest(f));
  return exponent + log * std::numbers::log2e;
}

}  // namespace sightline
