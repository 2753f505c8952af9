#pragma once

#include <immintrin.h>

#include <cstddef>

// The kernel's vectors in AVX-512 (F, DQ and VL).
// Only for files that are compiled with the flags these need: see match_kernel.h.

namespace sightline {
namespace {

struct Avx512 {
  using Floats = __m512;
  using Doubles = __m512d;
  static constexpr __mmask16 kUpper = 0xff00;

  static Floats floats(float x) { return _mm512_set1_ps(x); }
  static Doubles doubles(double x) { return _mm512_set1_pd(x); }
  static Floats load(const float* from) { return _mm512_loadu_ps(from); }
  static Doubles load(const double* from) { return _mm512_loadu_pd(from); }
  static void store(float* to, Floats x) { _mm512_storeu_ps(to, x); }
  static void store(double* to, Doubles x) { _mm512_storeu_pd(to, x); }
  static void store_as_floats(float* to, Doubles x) { _mm256_storeu_ps(to, _mm512_cvtpd_ps(x)); }
  static Floats add(Floats x, Floats y) { return _mm512_add_ps(x, y); }
  static Doubles add(Doubles x, Doubles y) { return _mm512_add_pd(x, y); }
  static Floats sub(Floats x, Floats y) { return _mm512_sub_ps(x, y); }
  static Floats mul(Floats x, Floats y) { return _mm512_mul_ps(x, y); }
  static Doubles mul(Doubles x, Doubles y) { return _mm512_mul_pd(x, y); }
  static Floats fma(Floats x, Floats y, Floats z) { return _mm512_fmadd_ps(x, y, z); }
  static Doubles fma(Doubles x, Doubles y, Doubles z) { return _mm512_fmadd_pd(x, y, z); }
  static Floats fnma(Floats x, Floats y, Floats z) { return _mm512_fnmadd_ps(x, y, z); }
  static Doubles fnma(Doubles x, Doubles y, Doubles z) { return _mm512_fnmadd_pd(x, y, z); }
  static Floats max(Floats x, Floats y) { return _mm512_max_ps(x, y); }
  static Doubles clamp(Doubles x, Doubles limit) {
    const Doubles low = _mm512_sub_pd(_mm512_setzero_pd(), limit);
    return _mm512_min_pd(_mm512_max_pd(x, low), limit);
  }
  static Doubles floor(Doubles x) {
    return _mm512_roundscale_pd(x, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
  }
  static unsigned differ(Doubles x, Doubles y) {
    return static_cast<unsigned>(_mm512_cmp_pd_mask(x, y, _CMP_NEQ_UQ));
  }
  static Floats as_exponent(Floats x) {
    return _mm512_castsi512_ps(_mm512_slli_epi32(_mm512_castps_si512(x), 23));
  }
  static Floats pair(const float* a, const float* b) {
    return _mm512_mask_broadcast_f32x8(_mm512_castps256_ps512(_mm256_loadu_ps(a)), kUpper,
                                       _mm256_loadu_ps(b));
  }
  // The first lanes of each half, so many of them; 0 in the others.
  static Floats keep(Floats x, std::size_t lanes_of_a, std::size_t lanes_of_b) {
    const unsigned of_a = (1u << lanes_of_a) - 1u;
    const unsigned of_b = (1u << lanes_of_b) - 1u;
    return _mm512_maskz_mov_ps(static_cast<__mmask16>(of_a | of_b << 8), x);
  }
  static Floats spread(const float* a, const float* b) {
    return _mm512_mask_mov_ps(_mm512_set1_ps(*a), kUpper, _mm512_set1_ps(*b));
  }

  struct Add {
    static __m512 of(__m512 x, __m512 y) { return _mm512_add_ps(x, y); }
  };
  struct Max {
    static __m512 of(__m512 x, __m512 y) { return _mm512_max_ps(x, y); }
  };
  // Neighbouring lanes of two rows combined: in each four lanes two of x, then two of y.
  template <class Operation>
  static Floats fold(Floats x, Floats y) {
    return Operation::of(_mm512_shuffle_ps(x, y, 0x88), _mm512_shuffle_ps(x, y, 0xdd));
  }
  // Neighbouring quarters combined, of rows folded twice: one number a point.
  template <class Operation>
  static Floats last(Floats x, Floats y) {
    return Operation::of(_mm512_shuffle_f32x4(x, y, 0x88), _mm512_shuffle_f32x4(x, y, 0xdd));
  }
  static Floats fold_sum(Floats x, Floats y) { return fold<Add>(x, y); }
  static Floats fold_largest(Floats x, Floats y) { return fold<Max>(x, y); }
  static Floats last_sum(Floats x, Floats y) { return last<Add>(x, y); }
  static Floats last_largest(Floats x, Floats y) { return last<Max>(x, y); }
};

}  // namespace

}  // namespace sightline
