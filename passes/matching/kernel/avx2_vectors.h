#pragma once

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

// The kernel's vectors in AVX2 and FMA: two registers where AVX-512 has one.
// Only for files that are compiled with the flags these need: see match_kernel.h.

namespace sightline {
namespace {

struct Avx2 {
  struct Floats {
    __m256 a, b;
  };
  struct Doubles {
    __m256d a, b;
  };

  static Floats floats(float x) { return {_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
  static Doubles doubles(double x) { return {_mm256_set1_pd(x), _mm256_set1_pd(x)}; }
  static Floats load(const float* from) {
    return {_mm256_loadu_ps(from), _mm256_loadu_ps(from + 8)};
  }
  static Doubles load(const double* from) {
    return {_mm256_loadu_pd(from), _mm256_loadu_pd(from + 4)};
  }
  static void store(float* to, Floats x) {
    _mm256_storeu_ps(to, x.a);
    _mm256_storeu_ps(to + 8, x.b);
  }
  static void store(double* to, Doubles x) {
    _mm256_storeu_pd(to, x.a);
    _mm256_storeu_pd(to + 4, x.b);
  }
  static void store_as_floats(float* to, Doubles x) {
    _mm_storeu_ps(to, _mm256_cvtpd_ps(x.a));
    _mm_storeu_ps(to + 4, _mm256_cvtpd_ps(x.b));
  }
  static Floats add(Floats x, Floats y) {
    return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)};
  }
  static Doubles add(Doubles x, Doubles y) {
    return {_mm256_add_pd(x.a, y.a), _mm256_add_pd(x.b, y.b)};
  }
  static Floats sub(Floats x, Floats y) {
    return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)};
  }
  static Floats mul(Floats x, Floats y) {
    return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)};
  }
  static Doubles mul(Doubles x, Doubles y) {
    return {_mm256_mul_pd(x.a, y.a), _mm256_mul_pd(x.b, y.b)};
  }
  static Floats fma(Floats x, Floats y, Floats z) {
    return {_mm256_fmadd_ps(x.a, y.a, z.a), _mm256_fmadd_ps(x.b, y.b, z.b)};
  }
  static Doubles fma(Doubles x, Doubles y, Doubles z) {
    return {_mm256_fmadd_pd(x.a, y.a, z.a), _mm256_fmadd_pd(x.b, y.b, z.b)};
  }
  static Floats fnma(Floats x, Floats y, Floats z) {
    return {_mm256_fnmadd_ps(x.a, y.a, z.a), _mm256_fnmadd_ps(x.b, y.b, z.b)};
  }
  static Doubles fnma(Doubles x, Doubles y, Doubles z) {
    return {_mm256_fnmadd_pd(x.a, y.a, z.a), _mm256_fnmadd_pd(x.b, y.b, z.b)};
  }
  static Floats max(Floats x, Floats y) {
    return {_mm256_max_ps(x.a, y.a), _mm256_max_ps(x.b, y.b)};
  }
  static Doubles clamp(Doubles x, Doubles limit) {
    const __m256d zero = _mm256_setzero_pd();
    const __m256d low = _mm256_sub_pd(zero, limit.a);
    return {_mm256_min_pd(_mm256_max_pd(x.a, low), limit.a),
            _mm256_min_pd(_mm256_max_pd(x.b, low), limit.b)};
  }
  static Doubles floor(Doubles x) { return {_mm256_floor_pd(x.a), _mm256_floor_pd(x.b)}; }
  static unsigned differ(Doubles x, Doubles y) {
    const int a = _mm256_movemask_pd(_mm256_cmp_pd(x.a, y.a, _CMP_NEQ_UQ));
    const int b = _mm256_movemask_pd(_mm256_cmp_pd(x.b, y.b, _CMP_NEQ_UQ));
    return static_cast<unsigned>(a) | static_cast<unsigned>(b) << 4;
  }
  static Floats as_exponent(Floats x) {
    return {_mm256_castsi256_ps(_mm256_slli_epi32(_mm256_castps_si256(x.a), 23)),
            _mm256_castsi256_ps(_mm256_slli_epi32(_mm256_castps_si256(x.b), 23))};
  }
  static Floats pair(const float* a, const float* b) {
    return {_mm256_loadu_ps(a), _mm256_loadu_ps(b)};
  }
  // The first lanes of each half, so many of them; 0 in the others.
  static Floats keep(Floats x, std::size_t lanes_of_a, std::size_t lanes_of_b) {
    return {_mm256_and_ps(x.a, first_lanes(lanes_of_a)),
            _mm256_and_ps(x.b, first_lanes(lanes_of_b))};
  }
  static __m256 first_lanes(std::size_t count) {
    static constexpr std::int32_t kOnesThenZeros[16] = {-1, -1, -1, -1, -1, -1, -1, -1};
    const auto* const from = reinterpret_cast<const __m256i_u*>(kOnesThenZeros + 8 - count);
    return _mm256_castsi256_ps(_mm256_loadu_si256(from));
  }
  static Floats spread(const float* a, const float* b) {
    return {_mm256_broadcast_ss(a), _mm256_broadcast_ss(b)};
  }

  struct Add {
    static __m256 of(__m256 x, __m256 y) { return _mm256_add_ps(x, y); }
  };
  struct Max {
    static __m256 of(__m256 x, __m256 y) { return _mm256_max_ps(x, y); }
  };
  template <class Operation>
  static __m256 fold_half(__m256 x, __m256 y) {
    return Operation::of(_mm256_shuffle_ps(x, y, 0x88), _mm256_shuffle_ps(x, y, 0xdd));
  }
  template <class Operation>
  static __m256 last_half(__m256 x, __m256 y) {
    return Operation::of(_mm256_permute2f128_ps(x, y, 0x20), _mm256_permute2f128_ps(x, y, 0x31));
  }
  // Neighbouring lanes of two rows combined: in each four lanes two of x, then two of y.
  static Floats fold_sum(Floats x, Floats y) {
    return {fold_half<Add>(x.a, y.a), fold_half<Add>(x.b, y.b)};
  }
  static Floats fold_largest(Floats x, Floats y) {
    return {fold_half<Max>(x.a, y.a), fold_half<Max>(x.b, y.b)};
  }
  // Neighbouring quarters combined, of rows folded twice: one number a point.
  static Floats last_sum(Floats x, Floats y) {
    return {last_half<Add>(x.a, x.b), last_half<Add>(y.a, y.b)};
  }
  static Floats last_largest(Floats x, Floats y) {
    return {last_half<Max>(x.a, x.b), last_half<Max>(y.a, y.b)};
  }
};

}  // namespace

}  // namespace sightline
