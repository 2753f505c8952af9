#pragma once

#include "passes/matching/kernel/match_kernel.h"

// The kernel, written once over a backend's vectors: 16 floats that are two points times eight NDs,
// or one number each of 16 points, and 8 doubles. Every multiply-add is fused where it says so and
// nowhere else, and sums over lanes follow one tree, so that all backends give the same bits.
//
// For a batch of 16 points: (1) positions and cells in double, relative to the cell's centre from
// there on; (2) for two points at a time the eight terms of each with first and second derivatives
// by the point's position; (3) their sums over the eight lanes, which leaves 16 points in 16 lanes;
// (4) the chain rule to the pose.

namespace sightline {
namespace {

constexpr int kTerms = 11;  // term, largest term, force (3), curvature (6)

struct alignas(64) BatchPoints {
  float offset_m[3][kKernelBatch];  // from the centre of the point's cell
  float arm_m[3][kKernelBatch];     // from the origin of the pose, map axes
};

// Within this many cells of the origin a cell's number is an int32 and has no ND beyond.
constexpr double kReach_cells = 0x1.0p30;

// Positions and cells of eight points; a bit for each whose cell is not the one it was in.
template <class B>
unsigned locate(const KernelInput& in, std::size_t first, std::size_t lane, BatchPoints& points) {
  using D = typename B::Doubles;
  const D x = B::load(in.x_m + first);
  const D y = B::load(in.y_m + first);
  const D z = B::load(in.z_m + first);
  double* const cells[3] = {in.cell_x + first, in.cell_y + first, in.cell_z + first};
  const D per_m = B::doubles(in.cells_per_m);
  const D cell_m = B::doubles(in.cell_m);
  const D reach_m = B::doubles(kReach_cells * in.cell_m);
  const D half = B::doubles(0.5);
  unsigned changed = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double* row = in.rotation + 3 * axis;
    const D arm =
        B::fma(B::doubles(row[0]), x, B::fma(B::doubles(row[1]), y, B::mul(B::doubles(row[2]), z)));
    const D place = B::clamp(B::add(arm, B::doubles(in.translation_m[axis])), reach_m);
    const D cell = B::floor(B::mul(place, per_m));
    changed |= B::differ(cell, B::load(cells[axis]));
    B::store(cells[axis], cell);
    B::store_as_floats(points.arm_m[axis] + lane, arm);
    B::store_as_floats(points.offset_m[axis] + lane, B::fnma(B::add(cell, half), cell_m, place));
  }
  if (first + 8 > in.count) changed &= first < in.count ? (1u << (in.count - first)) - 1u : 0u;
  return changed;
}

// Pairs of points in a batch. Steps that wait for each other are done one by one for all pairs.
constexpr std::size_t kPairs = kKernelBatch / 2;

// e^(-m2 / 2) = 2^(n + f) in place of each m2: n by adding a number so large that only whole ones
// fit, f by Chebyshev interpolation of degree 5 (relative error 1e-7), 2^n by shifting n into the
// exponent. 0 below 2^-127.
template <class B>
[[gnu::always_inline]] inline void gauss_of(typename B::Floats (&m2)[kPairs]) {
  using F = typename B::Floats;
  constexpr float kMinusHalfLog2e = -0.72134752044448170f;
  constexpr float kWhole = 12582912.0f + 127.0f;  // 1.5 * 2^23, and the exponent's bias
  constexpr float kSeries[] = {0.009676031768321991f, 0.055503569543361664f, 0.2402210682630539f,
                               0.6931471824645996f, 1.0000001192092896f};
  F biased[kPairs], f[kPairs], series[kPairs];
  for (std::size_t i = 0; i < kPairs; ++i) {
    const F power = B::max(B::mul(m2[i], B::floats(kMinusHalfLog2e)), B::floats(-127.0f));
    biased[i] = B::add(power, B::floats(kWhole));
    f[i] = B::sub(power, B::sub(biased[i], B::floats(kWhole)));
    series[i] = B::floats(0.0013390863314270973f);
  }
  for (const float coefficient : kSeries) {
    for (std::size_t i = 0; i < kPairs; ++i) {
      series[i] = B::fma(f[i], series[i], B::floats(coefficient));
    }
  }
  for (std::size_t i = 0; i < kPairs; ++i) m2[i] = B::mul(series[i], B::as_exponent(biased[i]));
}

// A point's record, row by row.
struct Rows {
  const float* begin;
  std::size_t lanes;

  // Eight floats, of which those beyond the lanes have no meaning.
  [[nodiscard]] const float* row(std::size_t number) const { return begin + number * lanes; }
};

// The records of a batch's points.
struct BatchRows {
  Rows of[kKernelBatch];

  BatchRows(const KernelInput& in, std::size_t first) {
    for (std::size_t i = 0; i < kKernelBatch; ++i) {
      const KernelPlace place = in.places[in.record[first + i]];
      of[i] = {record_at(in.records, place), lane_count(place)};
    }
  }
};

// The points of a pair: lanes of the batch, and their records. Points 0-3 with 4-7, then 8-11 with
// 12-15: so the sums come out in the order of points.
struct Pair {
  std::size_t a, b;
  const Rows& of_a;
  const Rows& of_b;

  Pair(const BatchRows& rows, std::size_t number)
      : a(number + (number & 4)), b(a + 4), of_a(rows.of[a]), of_b(rows.of[b]) {}
};

template <class B>
[[gnu::always_inline]] inline typename B::Floats load_row(const Pair& pair, std::size_t number) {
  return B::pair(pair.of_a.row(number), pair.of_b.row(number));
}

template <class B>
[[gnu::always_inline]] inline void load_information(const Pair& pair, typename B::Floats (&c)[6]) {
  for (std::size_t i = 0; i < 6; ++i) c[i] = load_row<B>(pair, 3 + i);
}

// Information times the distance from the mean; returns the square of the Mahalanobis distance.
template <class B>
[[gnu::always_inline]] inline typename B::Floats compute_push(const Pair& pair,
                                                              const BatchPoints& points,
                                                              typename B::Floats (&q)[3]) {
  using F = typename B::Floats;
  F d[3];
  for (std::size_t i = 0; i < 3; ++i) {
    d[i] = B::sub(B::spread(points.offset_m[i] + pair.a, points.offset_m[i] + pair.b),
                  load_row<B>(pair, i));
  }
  F c[6];
  load_information<B>(pair, c);
  q[0] = B::fma(c[0], d[0], B::fma(c[1], d[1], B::mul(c[2], d[2])));
  q[1] = B::fma(c[1], d[0], B::fma(c[3], d[1], B::mul(c[4], d[2])));
  q[2] = B::fma(c[2], d[0], B::fma(c[4], d[1], B::mul(c[5], d[2])));
  return B::fma(d[0], q[0], B::fma(d[1], q[1], B::mul(d[2], q[2])));
}

// Terms of the pairs of a batch from squares of Mahalanobis distances: e^(-m2 / 2) in lanes that a
// record has, 0 in the others.
template <class B>
[[gnu::always_inline]] inline void terms_of(const BatchRows& rows,
                                            typename B::Floats (&m2)[kPairs]) {
  gauss_of<B>(m2);
  for (std::size_t i = 0; i < kPairs; ++i) {
    const Pair pair(rows, i);
    m2[i] = B::keep(m2[i], pair.of_a.lanes, pair.of_b.lanes);
  }
}

// A term e with its derivatives by the points' positions.
template <class B>
[[gnu::always_inline]] inline void derive_pair(const Pair& pair, typename B::Floats e,
                                               const typename B::Floats (&q)[3],
                                               typename B::Floats (&terms)[kTerms]) {
  using F = typename B::Floats;
  F c[6];
  load_information<B>(pair, c);
  const F fx = B::mul(e, q[0]);
  const F fy = B::mul(e, q[1]);
  const F fz = B::mul(e, q[2]);
  terms[0] = e;
  terms[1] = e;
  terms[2] = fx;
  terms[3] = fy;
  terms[4] = fz;
  terms[5] = B::fnma(fx, q[0], B::mul(e, c[0]));
  terms[6] = B::fnma(fx, q[1], B::mul(e, c[1]));
  terms[7] = B::fnma(fx, q[2], B::mul(e, c[2]));
  terms[8] = B::fnma(fy, q[1], B::mul(e, c[3]));
  terms[9] = B::fnma(fy, q[2], B::mul(e, c[4]));
  terms[10] = B::fnma(fz, q[2], B::mul(e, c[5]));
}

// The terms of two pairs, half summed; of term 1 the largest.
template <class B>
[[gnu::always_inline]] inline void fold_terms(const typename B::Floats (&a)[kTerms],
                                              const typename B::Floats (&b)[kTerms],
                                              typename B::Floats (&folded)[kTerms]) {
  for (int t = 0; t < kTerms; ++t) {
    folded[t] = t == 1 ? B::fold_largest(a[t], b[t]) : B::fold_sum(a[t], b[t]);
  }
}

template <class B>
void add_to(float* lanes, typename B::Floats value) {
  B::store(lanes, B::add(B::load(lanes), value));
}

// With x = t + dt + exp([w]x) r: dx/dw = -[r]x, d2x/dw_i dw_j = (e_i r_j + e_j r_i)/2 - delta_ij r.
template <class B>
void add_rotations(const BatchPoints& points, const typename B::Floats (&t)[kTerms],
                   float (*sums)[kKernelBatch]) {
  using F = typename B::Floats;
  const F x = B::load(points.arm_m[0]);
  const F y = B::load(points.arm_m[1]);
  const F z = B::load(points.arm_m[2]);
  const F fx = t[2], fy = t[3], fz = t[4];
  add_to<B>(sums[5], B::fnma(z, fy, B::mul(y, fz)));
  add_to<B>(sums[6], B::fnma(x, fz, B::mul(z, fx)));
  add_to<B>(sums[7], B::fnma(y, fx, B::mul(x, fy)));
  // H -[r]x, and -[r]x^T of that.
  const F h[3][3] = {{t[5], t[6], t[7]}, {t[6], t[8], t[9]}, {t[7], t[9], t[10]}};
  F m[3][3];
  for (int i = 0; i < 3; ++i) {
    m[i][0] = B::fnma(h[i][1], z, B::mul(h[i][2], y));
    m[i][1] = B::fnma(h[i][2], x, B::mul(h[i][0], z));
    m[i][2] = B::fnma(h[i][0], y, B::mul(h[i][1], x));
    for (int j = 0; j < 3; ++j) add_to<B>(sums[14 + 3 * i + j], m[i][j]);
  }
  const F half = B::floats(0.5f);
  const F xx = B::mul(fx, x), yy = B::mul(fy, y), zz = B::mul(fz, z);
  const F xy = B::mul(half, B::fma(fx, y, B::mul(fy, x)));
  const F xz = B::mul(half, B::fma(fx, z, B::mul(fz, x)));
  const F yz = B::mul(half, B::fma(fy, z, B::mul(fz, y)));
  add_to<B>(sums[23], B::sub(B::fnma(z, m[1][0], B::mul(y, m[2][0])), B::add(yy, zz)));
  add_to<B>(sums[24], B::add(B::fnma(z, m[1][1], B::mul(y, m[2][1])), xy));
  add_to<B>(sums[25], B::add(B::fnma(z, m[1][2], B::mul(y, m[2][2])), xz));
  add_to<B>(sums[26], B::sub(B::fnma(x, m[2][1], B::mul(z, m[0][1])), B::add(xx, zz)));
  add_to<B>(sums[27], B::add(B::fnma(x, m[2][2], B::mul(z, m[0][2])), yz));
  add_to<B>(sums[28], B::sub(B::fnma(y, m[0][2], B::mul(x, m[1][2])), B::add(xx, yy)));
}

// Calls use(point) for each point of a batch whose cell changed.
template <class Use>
inline void for_changed(unsigned changed, const Use& use) {
  for (; changed != 0; changed &= changed - 1) {
    use(static_cast<std::size_t>(__builtin_ctz(changed)));
  }
}

// Positions and cells of a batch; a bit for each point whose cell is not the one it was in.
template <class B>
unsigned locate_batch(const KernelInput& in, std::size_t first, BatchPoints& points) {
  return locate<B>(in, first, 0, points) | locate<B>(in, first + 8, 8, points) << 8;
}

// Brings nearer what find_records() looks into for the points whose cells changed.
inline void fetch_places(const KernelInput& in, std::size_t first, unsigned changed) {
  if (in.columns.columns != nullptr) {
    for_changed(changed, [&](std::size_t i) {
      const KernelColumn* const column =
          find_column(in.columns, static_cast<std::int32_t>(in.cell_x[first + i]),
                      static_cast<std::int32_t>(in.cell_y[first + i]));
      if (column != nullptr) __builtin_prefetch(column);
    });
    return;
  }
  for_changed(changed, [&](std::size_t i) {
    in.fetch(in.grid, in.cell_x[first + i], in.cell_y[first + i], in.cell_z[first + i]);
  });
}

inline void find_records(const KernelInput& in, std::size_t first, unsigned changed) {
  if (in.columns.columns != nullptr) {
    for_changed(changed, [&](std::size_t i) {
      in.record[first + i] =
          find_record(in.columns, static_cast<std::int32_t>(in.cell_x[first + i]),
                      static_cast<std::int32_t>(in.cell_y[first + i]),
                      static_cast<std::int32_t>(in.cell_z[first + i]));
    });
    return;
  }
  for_changed(changed, [&](std::size_t i) {
    in.record[first + i] =
        in.find(in.grid, in.cell_x[first + i], in.cell_y[first + i], in.cell_z[first + i]);
  });
}

// The records that the points of a batch had last, on their way from memory.
inline void fetch_records(const KernelInput& in, std::size_t first) {
  for (std::size_t i = 0; i < kKernelBatch; ++i) {
    fetch_record(in.records, in.places[in.record[first + i]]);
  }
}

// In which order batches are located and computed. A map is larger than the caches: a batch is
// located this many batches before it is computed, and its records are fetched halfway.
struct Ahead {
  static constexpr std::size_t kLocateAhead = 6;
  static constexpr std::size_t kRecordsAhead = 3;
  static constexpr std::size_t kRing = 8;  // more than are on their way

  // Calls use(first, points) for each batch, in order.
  template <class B, class Use>
  static void for_batches(const KernelInput& in, const Use& use) {
    BatchPoints points[kRing];
    unsigned changed[kRing];
    const std::size_t batches = (in.count + kKernelBatch - 1) / kKernelBatch;
    for (std::size_t step = 0; step < batches + kLocateAhead; ++step) {
      if (step < batches) {
        const std::size_t first = step * kKernelBatch;
        changed[step % kRing] = locate_batch<B>(in, first, points[step % kRing]);
        fetch_places(in, first, changed[step % kRing]);
      }
      // Both are too large to be a batch before the first one's turn.
      const std::size_t found = step - (kLocateAhead - kRecordsAhead);
      if (found < batches) {
        find_records(in, found * kKernelBatch, changed[found % kRing]);
        if (changed[found % kRing] != 0) fetch_records(in, found * kKernelBatch);
      }
      const std::size_t computed = step - kLocateAhead;
      if (computed < batches) use(computed * kKernelBatch, points[computed % kRing]);
    }
  }
};

template <class B, class Order>
void run_score(const KernelInput& in, KernelSums& sums) {
  using F = typename B::Floats;
  B::store(sums.lanes[0], B::floats(0.0f));
  Order::template for_batches<B>(in, [&](std::size_t first, const BatchPoints& points) {
    const BatchRows rows(in, first);
    F e[kPairs], push[3];
    for (std::size_t i = 0; i < kPairs; ++i) {
      e[i] = compute_push<B>(Pair(rows, i), points, push);
    }
    terms_of<B>(rows, e);
    const F low = B::fold_sum(B::fold_sum(e[0], e[1]), B::fold_sum(e[2], e[3]));
    const F high = B::fold_sum(B::fold_sum(e[4], e[5]), B::fold_sum(e[6], e[7]));
    add_to<B>(sums.lanes[0], B::last_sum(low, high));
  });
}

template <class B, class Order>
void run_kernel(const KernelInput& in, KernelSums& sums) {
  using F = typename B::Floats;
  for (int s = 0; s < kKernelSums; ++s) B::store(sums.lanes[s], B::floats(0.0f));
  Order::template for_batches<B>(in, [&](std::size_t first, const BatchPoints& points) {
    const BatchRows rows(in, first);
    F e[kPairs], push[kPairs][3];
    for (std::size_t i = 0; i < kPairs; ++i) {
      e[i] = compute_push<B>(Pair(rows, i), points, push[i]);
    }
    terms_of<B>(rows, e);
    // Of two pairs, folded at once: they need not wait in memory for the others.
    const auto fold_two = [&](std::size_t i, F(&folded)[kTerms]) {
      F a[kTerms], b[kTerms];
      derive_pair<B>(Pair(rows, i), e[i], push[i], a);
      derive_pair<B>(Pair(rows, i + 1), e[i + 1], push[i + 1], b);
      fold_terms<B>(a, b, folded);
    };
    F quarters[4][kTerms], low[kTerms], high[kTerms], totals[kTerms];
    for (std::size_t i = 0; i < 4; ++i) fold_two(2 * i, quarters[i]);
    fold_terms<B>(quarters[0], quarters[1], low);
    fold_terms<B>(quarters[2], quarters[3], high);
    for (int t = 0; t < kTerms; ++t) {
      totals[t] = t == 1 ? B::last_largest(low[t], high[t]) : B::last_sum(low[t], high[t]);
    }
    for (int t = 0; t < 5; ++t) add_to<B>(sums.lanes[t], totals[t]);
    for (int t = 5; t < kTerms; ++t) add_to<B>(sums.lanes[t + 3], totals[t]);
    add_rotations<B>(points, totals, sums.lanes);
  });
}

template <class B, class Order>
KernelVersion kernel_of() {
  return {run_kernel<B, Order>, run_score<B, Order>};
}

}  // namespace
}  // namespace sightline
