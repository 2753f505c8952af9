#pragma once

#include <bit>
#include <cstdint>

// a b + c rounded once, from plain additions and multiplications: the bits of a fused multiply-add
// for processors without one, in code that the compiler can turn into vectors. Rounding to odd (to
// the neighbour whose last bit is 1 unless exact) loses nothing that a second, narrower rounding
// needs (Boldo and Melquiond, Emulation of FMA and Correctly Rounded Sums: Proved Algorithms Using
// Rounding to Odd, 2008). Valid as long as nothing overflows or leaves the normal numbers.

namespace sightline {

namespace software_fma_detail {

struct Exact {
  double value = 0.0;  // rounded to nearest
  double rest = 0.0;   // value + rest is exact
};

inline Exact sum(double a, double b) {
  const double value = a + b;
  const double of_b = value - a;
  return {value, (a - (value - of_b)) + (b - of_b)};
}

// The upper 26 bits; the lower ones are what is left.
inline double upper_half(double a) {
  const double shifted = a * 134217729.0;  // 2^27 + 1
  return shifted - (shifted - a);
}

inline Exact product(double a, double b) {
  const double value = a * b;
  const double a1 = upper_half(a);
  const double b1 = upper_half(b);
  const double a2 = a - a1;
  const double b2 = b - b1;
  return {value, ((a1 * b1 - value) + a1 * b2 + a2 * b1) + a2 * b2};
}

// a + b to odd: from the nearest one step towards the exact value where the last bit is 0 and
// something is left. Without a branch.
inline double odd_sum(double a, double b) {
  const Exact exact = sum(a, b);
  const auto bits = std::bit_cast<std::int64_t>(exact.value);
  const auto rest = std::bit_cast<std::int64_t>(exact.rest);
  const std::int64_t is_even = (bits & 1) ^ 1;
  const std::int64_t has_rest = exact.rest != 0.0 ? 1 : 0;
  const std::int64_t away =
      1 - 2 * static_cast<std::int64_t>(static_cast<std::uint64_t>(bits ^ rest) >> 63);
  return std::bit_cast<double>(bits + (is_even & has_rest) * away);
}

}  // namespace software_fma_detail

// The product of two floats is exact in double.
inline float software_fma(float a, float b, float c) {
  return static_cast<float>(software_fma_detail::odd_sum(
      static_cast<double>(a) * static_cast<double>(b), static_cast<double>(c)));
}

inline double software_fma(double a, double b, double c) {
  using namespace software_fma_detail;
  const Exact ab = product(a, b);
  const Exact low = sum(c, ab.rest);
  const Exact high = sum(ab.value, low.value);
  return high.value + odd_sum(low.rest, high.rest);
}

}  // namespace sightline
