#pragma once

#include <cstring>

#include "passes/matching/kernel/software_fma.h"

// The kernel's vectors for any machine, in loops that a compiler turns into whatever vectors it may
// use. Only for files that are compiled with the flags these need: see match_kernel.h.

namespace sightline {
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
