#include "compiler/base/portable_math.h"

#include <cmath>
#include <numbers>

namespace sightline {
namespace {

// Power series, summed from the smallest term. Each stops where its next term is below 2^-54 of the
// first over the interval it serves.

// |x| <= pi / 4 (and a rounding error).
double sin_series(double x) {
  const double x2 = x * x;
  double sum = 1.0;
  for (int n = 18; n >= 2; n -= 2) sum = 1.0 - sum * x2 / (n * (n + 1.0));
  return x * sum;
}

double cos_series(double x) {
  const double x2 = x * x;
  double sum = 1.0;
  for (int n = 19; n >= 1; n -= 2) sum = 1.0 - sum * x2 / (n * (n + 1.0));
  return sum;
}

// |x| <= 0.2: atan x = x - x^3/3 + x^5/5 - ...
double atan_series(double x) {
  const double x2 = x * x;
  double sum = 0.0;
  for (int n = 25; n >= 3; n -= 2) sum = x2 * (1.0 / n - sum);
  return x * (1.0 - sum);
}

// 0 <= x <= 1, by halving the angle twice: tan(a/2) = tan a / (1 + sqrt(1 + tan^2 a)).
double atan_to_one(double x) {
  const double half = x / (1.0 + std::sqrt(1.0 + x * x));
  const double quarter = half / (1.0 + std::sqrt(1.0 + half * half));
  return 4.0 * atan_series(quarter);
}

}  // namespace

SinCos portable_sin_cos(double angle_rad) {
  // pi / 2 in three parts; the first two have so few bits that whole multiples are exact.
  constexpr double kHigh = 0x1.921fb544p+0;
  constexpr double kMiddle = 0x1.0b4611a6p-34;
  constexpr double kLow = 0x1.3198a2e037073p-69;
  const double turns = std::floor(angle_rad * (2.0 * std::numbers::inv_pi) + 0.5);
  const double rest = ((angle_rad - turns * kHigh) - turns * kMiddle) - turns * kLow;
  const double s = sin_series(rest);
  const double c = cos_series(rest);
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
  const double run = std::abs(x);
  const double rise = std::abs(y);
  if (run == 0.0 && rise == 0.0) return 0.0;
  double angle_rad =
      rise <= run ? atan_to_one(rise / run) : 0.5 * std::numbers::pi - atan_to_one(run / rise);
  if (x < 0.0) angle_rad = std::numbers::pi - angle_rad;
  return y < 0.0 ? -angle_rad : angle_rad;
}

double portable_log(double x) {
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);  // [0.5, 1)
  if (mantissa < 0.5 * std::numbers::sqrt2) {
    mantissa *= 2.0;
    --exponent;
  }
  // log m = 2 atanh((m - 1) / (m + 1)), the argument at most 0.172 in size.
  const double t = (mantissa - 1.0) / (mantissa + 1.0);
  const double t2 = t * t;
  double sum = 0.0;
  for (int n = 23; n >= 3; n -= 2) sum = t2 * (1.0 / n + sum);
  return exponent * std::numbers::ln2 + 2.0 * t * (1.0 + sum);
}

}  // namespace sightline
