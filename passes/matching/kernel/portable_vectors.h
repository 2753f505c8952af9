#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

// The kernel's vectors for any machine, in loops that a compiler turns into whatever vectors it may
// use. Only for files that are compiled with the flags these need: see match_kernel.h.

namespace sightline {

// a b + c rounded once, from plain additions and multiplications: the bits of a fused multiply-add
// for processors without one, in code that the compiler can turn into vectors. Rounding to odd (to
// the neighbour whose last bit is 1 unless exact) loses nothing that a second, narrower rounding
// needs (Boldo and Melquiond, Emulation of FMA and Correctly Rounded Sums: Proved Algorithms Using
// Rounding to Odd, 2008). Valid as long as nothing overflows or leaves the normal numbers.

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

namespace {

struct Portable {
  struct Floats {
    float v[16];
  };
  struct Doubles {
    double v[8];
  };

  template <class V, class Operation>
  static V each(Operation operation) {
    V result;
    for (std::size_t i = 0; i < sizeof(V::v) / sizeof(V::v[0]); ++i) result.v[i] = operation(i);
    return result;
  }

  static Floats floats(float a) {
    return each<Floats>([&](std::size_t) { return a; });
  }
  static Doubles doubles(double a) {
    return each<Doubles>([&](std::size_t) { return a; });
  }
  static Floats load(const float* from) {
    return each<Floats>([&](std::size_t i) { return from[i]; });
  }
  static Doubles load(const double* from) {
    return each<Doubles>([&](std::size_t i) { return from[i]; });
  }
  static void store(float* to, const Floats& a) { std::memcpy(to, a.v, sizeof a.v); }
  static void store(double* to, const Doubles& a) { std::memcpy(to, a.v, sizeof a.v); }
  static void store_as_floats(float* to, const Doubles& a) {
    for (int i = 0; i < 8; ++i) to[i] = static_cast<float>(a.v[i]);
  }
  template <class V>
  static V add(const V& a, const V& b) {
    return each<V>([&](std::size_t i) { return a.v[i] + b.v[i]; });
  }
  template <class V>
  static V mul(const V& a, const V& b) {
    return each<V>([&](std::size_t i) { return a.v[i] * b.v[i]; });
  }
  static Floats sub(const Floats& a, const Floats& b) {
    return each<Floats>([&](std::size_t i) { return a.v[i] - b.v[i]; });
  }
  // a b + c
  template <class V>
  static V fma(const V& a, const V& b, const V& c) {
    return each<V>([&](std::size_t i) { return software_fma(a.v[i], b.v[i], c.v[i]); });
  }
  // c - a b
  template <class V>
  static V fnma(const V& a, const V& b, const V& c) {
    return each<V>([&](std::size_t i) { return software_fma(-a.v[i], b.v[i], c.v[i]); });
  }
  static Floats max(const Floats& a, const Floats& b) {
    return each<Floats>([&](std::size_t i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
  }
  // To [-limit, limit].
  static Doubles clamp(const Doubles& a, const Doubles& limit) {
    return each<Doubles>([&](std::size_t i) {
      const double low = a.v[i] > -limit.v[i] ? a.v[i] : -limit.v[i];
      return low < limit.v[i] ? low : limit.v[i];
    });
  }
  // Of numbers that an int32 holds.
  static Doubles floor(const Doubles& a) {
    return each<Doubles>([&](std::size_t i) {
      const auto whole = static_cast<double>(static_cast<std::int32_t>(a.v[i]));
      return whole - (a.v[i] < whole ? 1.0 : 0.0);
    });
  }
  // Bit i is set where lane i differs, or either is NaN.
  static unsigned differ(const Doubles& a, const Doubles& b) {
    unsigned mask = 0;
    for (unsigned i = 0; i < 8; ++i) mask |= a.v[i] == b.v[i] ? 0u : 1u << i;
    return mask;
  }
  // The low bits of the mantissa as an exponent.
  static Floats as_exponent(const Floats& a) {
    return each<Floats>([&](std::size_t i) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &a.v[i], sizeof bits);
      bits <<= 23;
      float power = 0.0f;
      std::memcpy(&power, &bits, sizeof power);
      return power;
    });
  }
  static Floats pair(const float* a, const float* b) {
    return each<Floats>([&](std::size_t i) { return i < 8 ? a[i] : b[i - 8]; });
  }
  // The first lanes of each half, so many of them; 0 in the others.
  static Floats keep(const Floats& x, std::size_t lanes_of_a, std::size_t lanes_of_b) {
    return each<Floats>([&](std::size_t i) {
      return (i < 8 ? i < lanes_of_a : i - 8 < lanes_of_b) ? x.v[i] : 0.0f;
    });
  }
  static Floats spread(const float* a, const float* b) {
    return each<Floats>([&](std::size_t i) { return i < 8 ? *a : *b; });
  }

  static float sum(float a, float b) { return a + b; }
  static float largest(float a, float b) { return a > b ? a : b; }
  // Neighbouring lanes of two rows combined: in each four lanes two of x, then two of y.
  template <class Operation>
  static Floats fold(const Floats& x, const Floats& y, Operation operation) {
    return each<Floats>([&](std::size_t lane) {
      const float* v = ((lane & 2) == 0 ? x : y).v + (lane & 12) + 2 * (lane & 1);
      return operation(v[0], v[1]);
    });
  }
  // Neighbouring quarters combined, of rows folded twice: one number a point.
  template <class Operation>
  static Floats last(const Floats& x, const Floats& y, Operation operation) {
    return each<Floats>([&](std::size_t lane) {
      const float* v = (lane < 8 ? x : y).v + 2 * (lane & 4) + (lane & 3);
      return operation(v[0], v[4]);
    });
  }
  static Floats fold_sum(const Floats& x, const Floats& y) { return fold(x, y, sum); }
  static Floats fold_largest(const Floats& x, const Floats& y) { return fold(x, y, largest); }
  static Floats last_sum(const Floats& x, const Floats& y) { return last(x, y, sum); }
  static Floats last_largest(const Floats& x, const Floats& y) { return last(x, y, largest); }
};

}  // namespace
}  // namespace sightline
