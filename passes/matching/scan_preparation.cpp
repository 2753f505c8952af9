#include "passes/matching/scan_preparation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>

#include "formats/grid/cell_index.h"
#include "passes/matching/voxel_table.h"

namespace sightline {
namespace {

struct Voxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;

  void add(std::span<const Eigen::Vector3d> points_m) {
    Eigen::Vector3d sum = sum_m;  // in registers
    for (const Eigen::Vector3d& point_m : points_m) sum += point_m;
    sum_m = sum;
    count += static_cast<double>(points_m.size());
  }
  [[nodiscard]] Eigen::Vector3d centroid_m() const { return sum_m / count; }
};

struct Extent {
  CellKey low;
  CellKey high;
  int y_bits = 0;
  int z_bits = 0;
  int bits = 0;  // that tell all keys of the extent apart
};

int bits_for(std::int32_t low, std::int32_t high) {
  return static_cast<int>(
      std::bit_width(static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low)));
}

Extent extent_between(const CellKey& low, const CellKey& high) {
  Extent extent{low, high};
  extent.y_bits = bits_for(low.y, high.y);
  extent.z_bits = bits_for(low.z, high.z);
  extent.bits = bits_for(low.x, high.x) + extent.y_bits + extent.z_bits;
  return extent;
}

// floor(x / leaf) never falls where x grows, so the corners of all points have the outermost keys.
VoxelBox box_of(std::span<const Eigen::Vector3d> points_m, double leaf_m) {
  using TwoPoints = Eigen::Array<double, 6, 1>;  // fill registers that one would not
  TwoPoints low_m = points_m.front().replicate<2, 1>().array();
  TwoPoints high_m = low_m;
  for (std::size_t i = 0; i + 1 < points_m.size(); i += 2) {
    const Eigen::Map<const TwoPoints> two_m(points_m[i].data());
    low_m = low_m.min(two_m);
    high_m = high_m.max(two_m);
  }
  const Eigen::Vector3d& last_m = points_m.back();
  const Eigen::Vector3d lowest_m =
      low_m.head<3>().min(low_m.tail<3>()).min(last_m.array()).matrix();
  const Eigen::Vector3d highest_m =
      high_m.head<3>().max(high_m.tail<3>()).max(last_m.array()).matrix();
  return {cell_key(lowest_m, leaf_m), cell_key(highest_m, leaf_m)};
}

Extent extent_of(std::span<const CellKey> keys) {
  CellKey low = keys.front();
  CellKey high = low;
  for (const CellKey& key : keys) {
    low = {std::min(low.x, key.x), std::min(low.y, key.y), std::min(low.z, key.z)};
    high = {std::max(high.x, key.x), std::max(high.y, key.y), std::max(high.z, key.z)};
  }
  return extent_between(low, high);
}

// The key's place in the order of keys; needs extent.bits of at most 64.
std::uint64_t rank_of(const CellKey& key, const Extent& extent) {
  const auto from = [](std::int32_t low, std::int32_t value) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value) -
                                      static_cast<std::uint32_t>(low));
  };
  const std::uint64_t plane =
      from(extent.low.x, key.x) << extent.y_bits | from(extent.low.y, key.y);
  return plane << extent.z_bits | from(extent.low.z, key.z);
}

// Some consecutive points, or voxels, of one rank.
template <class Number>
struct Ranked {
  Number rank;
  std::uint32_t begin;
  std::uint32_t count;
};

// Memory that is not filled with zeros first.
template <class Number>
using RankedArray = std::unique_ptr<Ranked<Number>[]>;

template <class Number>
RankedArray<Number> make_ranked(std::size_t count) {
  return RankedArray<Number>(new Ranked<Number>[count]);
}

// By counting digits, the lowest first: time in proportion to `count`, equal ranks stay in order.
template <class Number>
void sort_by_rank(std::size_t count, int bits, RankedArray<Number>& items) {
  constexpr int kDigitBits = 8;  // so few heaps that each keeps a line of the nearest cache
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  RankedArray<Number> other = make_ranked<Number>(count);
  for (int shift = 0; shift < bits; shift += kDigitBits) {
    const auto digit_of = [&](const Ranked<Number>& item) {
      return static_cast<std::size_t>(item.rank >> shift) & (kDigits - 1);
    };
    std::array<std::uint32_t, kDigits + 1> begin{};
    for (std::size_t i = 0; i < count; ++i) ++begin[digit_of(items[i]) + 1];
    for (std::size_t digit = 0; digit < kDigits; ++digit) begin[digit + 1] += begin[digit];
    for (std::size_t i = 0; i < count; ++i) other[begin[digit_of(items[i])]++] = items[i];
    items.swap(other);
  }
}

// Runs of points in one voxel, chunk by chunk so that keys stay in the nearest caches: calls
// use(runs) for each, `begin` counted from the first of all points. Stops where that is false.
template <class Use>
void for_runs(std::span<const Eigen::Vector3d> points_m, double leaf_m, const Use& use) {
  constexpr std::size_t kChunk = 2048;
  std::array<CellKey, kChunk> keys;
  std::vector<CellRun> runs(kChunk);
  for (std::size_t first = 0; first < points_m.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, points_m.size() - first);
    cell_keys(points_m.subspan(first, count), leaf_m, std::span(keys).first(count));
    const std::size_t found = find_runs(std::span(keys).first(count), runs);
    for (std::size_t i = 0; i < found; ++i) runs[i].begin += static_cast<std::uint32_t>(first);
    if (!use(std::span<const CellRun>(runs).first(found))) return;
  }
}

// Of runs ascending by rank; each rank is one voxel, whose runs are in their order.
template <class Number>
std::vector<Eigen::Vector3d> centroids_of(std::span<const Eigen::Vector3d> points_m,
                                          std::span<const Ranked<Number>> runs) {
  constexpr std::size_t kAhead = 16;
  std::size_t voxel_count = 1;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    voxel_count += runs[i].rank != runs[i - 1].rank ? 1 : 0;
  }
  std::vector<Eigen::Vector3d> centroids_m;
  centroids_m.reserve(voxel_count);
  Voxel voxel;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (i + kAhead < runs.size()) __builtin_prefetch(&points_m[runs[i + kAhead].begin]);
    voxel.add(points_m.subspan(runs[i].begin, runs[i].count));
    if (i + 1 < runs.size() && runs[i + 1].rank == runs[i].rank) continue;
    centroids_m.push_back(voxel.centroid_m());
    voxel = Voxel();
  }
  return centroids_m;
}

template <class Number>
std::vector<Eigen::Vector3d> subsample_by_rank(std::span<const Eigen::Vector3d> points_m,
                                               double leaf_m, const Extent& extent) {
  RankedArray<Number> ranked = make_ranked<Number>(points_m.size());
  std::size_t count = 0;
  for_runs(points_m, leaf_m, [&](std::span<const CellRun> runs) {
    for (const CellRun& run : runs) {
      ranked[count++] = {static_cast<Number>(rank_of(run.key, extent)), run.begin, run.count};
    }
    return true;
  });
  sort_by_rank(count, extent.bits, ranked);
  return centroids_of(points_m, std::span<const Ranked<Number>>(ranked.get(), count));
}

// Where no number holds a key: runs sorted by their keys, ranks counted.
std::vector<Eigen::Vector3d> subsample_by_comparing(std::span<const Eigen::Vector3d> points_m,
                                                    double leaf_m) {
  std::vector<CellRun> all;
  for_runs(points_m, leaf_m, [&](std::span<const CellRun> runs) {
    all.insert(all.end(), runs.begin(), runs.end());
    return true;
  });
  std::ranges::stable_sort(all, {}, &CellRun::key);
  std::vector<Ranked<std::uint32_t>> ranked;
  std::uint32_t rank = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 0 && all[i].key != all[i - 1].key) ++rank;
    ranked.push_back({rank, all[i].begin, all[i].count});
  }
  return centroids_of(points_m, std::span<const Ranked<std::uint32_t>>(ranked));
}

// Three ways to the same bits, since each adds the points of a voxel in their order: a scan is
// small enough for a table of all cells (voxel_table.h). Of more points, where few share a voxel,
// sorting all runs costs less than a table of voxels that fits no cache.
std::vector<Eigen::Vector3d> subsample_by_sorting(std::span<const Eigen::Vector3d> points_m,
                                                  double leaf_m, const VoxelBox& box) {
  const Extent extent = extent_between(box.low, box.high);
  if (extent.bits > 64) return subsample_by_comparing(points_m, leaf_m);
  if (extent.bits > 32) return subsample_by_rank<std::uint64_t>(points_m, leaf_m, extent);
  return subsample_by_rank<std::uint32_t>(points_m, leaf_m, extent);
}

// Numbers of keys, ascending by key. All keys differ.
std::vector<std::uint32_t> order_of(std::span<const CellKey> keys) {
  std::vector<std::uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  const Extent extent = extent_of(keys);
  if (extent.bits > 64) {
    std::ranges::sort(order, {}, [&](std::uint32_t number) { return keys[number]; });
    return order;
  }
  RankedArray<std::uint64_t> ranked = make_ranked<std::uint64_t>(keys.size());
  for (const std::uint32_t number : order) {
    ranked[number] = {rank_of(keys[number], extent), number, 1};
  }
  sort_by_rank(keys.size(), extent.bits, ranked);
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = ranked[i].begin;
  return order;
}

// Nothing where the first points already say that sorting is cheaper.
std::optional<std::vector<Eigen::Vector3d>> subsample_by_hash(
    std::span<const Eigen::Vector3d> points_m, double leaf_m) {
  constexpr std::size_t kTrial = 1 << 17;  // points; about a scan
  CellTable<Voxel> voxels;
  std::size_t run_count = 0;
  bool is_sparse = false;
  for_runs(points_m, leaf_m, [&](std::span<const CellRun> runs) {
    voxels.add(runs, [&](Voxel& voxel, const CellRun& run) {
      voxel.add(points_m.subspan(run.begin, run.count));
    });
    run_count += runs.size();
    const bool is_trial_over = runs.back().begin + runs.back().count == kTrial;
    is_sparse = is_trial_over && 4 * voxels.keys().size() > 3 * run_count;
    return !is_sparse;
  });
  if (is_sparse) return std::nullopt;
  std::vector<Eigen::Vector3d> centroids_m;
  centroids_m.reserve(voxels.keys().size());
  for (const std::uint32_t voxel : order_of(voxels.keys())) {
    centroids_m.push_back(voxels.values()[voxel].centroid_m());
  }
  return centroids_m;
}

}  // namespace

std::vector<Eigen::Vector3d> crop(std::span<const Eigen::Vector3d> points_m, double range_m) {
  const double range2_m2 = range_m * range_m;
  std::vector<Eigen::Vector3d> within_m(points_m.size());
  // Without a branch: which returns are near is as good as random.
  std::size_t count = 0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    within_m[count] = points_m[i];
    count += points_m[i].squaredNorm() <= range2_m2 ? 1 : 0;
  }
  within_m.resize(count);
  return within_m;
}

std::vector<Eigen::Vector3d> voxel_subsample(std::span<const Eigen::Vector3d> points_m,
                                             double leaf_m) {
  constexpr std::size_t kFewPoints = 1 << 18;
  if (points_m.empty()) return {};
  const VoxelBox box = box_of(points_m, leaf_m);
  if (points_m.size() <= kFewPoints && cell_count(box) <= kMostTableCells) {
    VoxelTable voxels;
    voxels.begin(box);
    voxels.add(points_m, leaf_m);
    return voxels.take_centroids_m();
  }
  if (points_m.size() > kFewPoints) {
    std::optional<std::vector<Eigen::Vector3d>> centroids_m = subsample_by_hash(points_m, leaf_m);
    if (centroids_m) return std::move(*centroids_m);
  }
  return subsample_by_sorting(points_m, leaf_m, box);
}

}  // namespace sightline
