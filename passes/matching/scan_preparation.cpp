#include "passes/matching/scan_preparation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "formats/ndt_map.h"

namespace sightline {
namespace {

struct Voxel {
  CellKey key;
  std::uint32_t count = 0;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
};

// floor(x / leaf) of `count` coordinates, each in the low 32 bits of its number. The product with
// 1 / leaf is as good, and far cheaper, wherever it does not lie at a whole number. Adding 1.5 *
// 2^52 rounds to a whole number and leaves it in the low bits. No branch and no conversion: the
// first loop becomes vector code on any x86-64.
void number_voxels(const double* x_m, std::size_t count, double leaf_m, std::int64_t* numbers) {
  constexpr double kWhole = 0x1.8p52;
  constexpr double kSure = 0.5 - 1e-6;  // product and quotient differ by far less than the rest
  const double per_m = 1.0 / leaf_m;
  std::int64_t doubts = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double product = x_m[i] * per_m - 0.5;
    const double shifted = product + kWhole;
    numbers[i] = std::bit_cast<std::int64_t>(shifted);
    // Positive doubles compare as their bits do: the sign says that this one is larger.
    const double rest = std::abs(product - (shifted - kWhole));
    doubts |= std::bit_cast<std::int64_t>(kSure) - std::bit_cast<std::int64_t>(rest);
  }
  if (doubts >= 0) return;
  for (std::size_t i = 0; i < count; ++i) numbers[i] = floor_to_int(x_m[i] / leaf_m);
}

// Voxels by key: open addressing over indices into `voxels`, at most half full.
class VoxelTable {
 public:
  VoxelTable() : slots_(kFirstSize, kFree) {}

  Voxel& at(const CellKey& key) {
    // Neighbours in a scan often share a voxel.
    if (last_ < voxels_.size() && voxels_[last_].key == key) return voxels_[last_];
    std::size_t slot = slot_of(key);
    while (slots_[slot] != kFree && voxels_[slots_[slot]].key != key) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    if (slots_[slot] != kFree) {
      last_ = slots_[slot];
      return voxels_[last_];
    }
    last_ = voxels_.size();
    slots_[slot] = static_cast<std::uint32_t>(last_);
    voxels_.emplace_back().key = key;
    if (2 * voxels_.size() > slots_.size()) grow();
    return voxels_[last_];
  }

  std::vector<Voxel> take() { return std::move(voxels_); }

 private:
  static constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::size_t kFirstSize = 4096;

  [[nodiscard]] std::size_t slot_of(const CellKey& key) const {
    const std::uint64_t mixed = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ULL ^
                                static_cast<std::uint32_t>(key.y) * 0xbf58476d1ce4e5b9ULL ^
                                static_cast<std::uint32_t>(key.z) * 0x94d049bb133111ebULL;
    return static_cast<std::size_t>(mixed >> 32) & (slots_.size() - 1);
  }

  void grow() {
    slots_.assign(4 * slots_.size(), kFree);
    for (std::size_t i = 0; i < voxels_.size(); ++i) {
      std::size_t slot = slot_of(voxels_[i].key);
      while (slots_[slot] != kFree) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<Voxel> voxels_;
  std::vector<std::uint32_t> slots_;
  std::size_t last_ = 0;
};

// A voxel's place in the order of keys as one number, where the extent of all of them allows.
struct Rank {
  std::uint64_t key = 0;
  std::uint32_t voxel = 0;
};

struct Extent {
  CellKey low{std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::max(),
              std::numeric_limits<std::int32_t>::max()};
  CellKey high{std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::min(),
               std::numeric_limits<std::int32_t>::min()};
};

Extent extent_of(const std::vector<Voxel>& voxels) {
  Extent extent;
  for (const Voxel& voxel : voxels) {
    extent.low.x = std::min(extent.low.x, voxel.key.x);
    extent.low.y = std::min(extent.low.y, voxel.key.y);
    extent.low.z = std::min(extent.low.z, voxel.key.z);
    extent.high.x = std::max(extent.high.x, voxel.key.x);
    extent.high.y = std::max(extent.high.y, voxel.key.y);
    extent.high.z = std::max(extent.high.z, voxel.key.z);
  }
  return extent;
}

// By counting digits, the lowest first: time in proportion to the number of voxels.
void sort_ranks(std::vector<Rank>& ranks, int bits) {
  constexpr int kDigitBits = 11;
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  std::vector<Rank> other(ranks.size());
  for (int shift = 0; shift < bits; shift += kDigitBits) {
    std::array<std::size_t, kDigits + 1> begin{};
    for (const Rank& rank : ranks) ++begin[((rank.key >> shift) & (kDigits - 1)) + 1];
    for (std::size_t digit = 0; digit < kDigits; ++digit) begin[digit + 1] += begin[digit];
    for (const Rank& rank : ranks) other[begin[(rank.key >> shift) & (kDigits - 1)]++] = rank;
    ranks.swap(other);
  }
}

int bits_for(std::int32_t low, std::int32_t high) {
  return static_cast<int>(
      std::bit_width(static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low)));
}

// Indices of voxels, ascending by key.
std::vector<Rank> order_of(const std::vector<Voxel>& voxels) {
  const Extent extent = extent_of(voxels);
  const int y_bits = bits_for(extent.low.y, extent.high.y);
  const int z_bits = bits_for(extent.low.z, extent.high.z);
  const int bits = bits_for(extent.low.x, extent.high.x) + y_bits + z_bits;
  std::vector<Rank> ranks(voxels.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) ranks[i].voxel = static_cast<std::uint32_t>(i);
  if (bits > 64) {
    std::sort(ranks.begin(), ranks.end(), [&](const Rank& a, const Rank& b) {
      return voxels[a.voxel].key < voxels[b.voxel].key;
    });
    return ranks;
  }
  const auto from = [](std::int32_t low, std::int32_t value) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value) -
                                      static_cast<std::uint32_t>(low));
  };
  for (Rank& rank : ranks) {
    const CellKey& key = voxels[rank.voxel].key;
    rank.key = ((from(extent.low.x, key.x) << y_bits | from(extent.low.y, key.y)) << z_bits) |
               from(extent.low.z, key.z);
  }
  sort_ranks(ranks, bits);
  return ranks;
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
  constexpr std::size_t kBlock = 32;
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  std::array<std::int64_t, 3 * kBlock> numbers{};
  VoxelTable table;
  for (std::size_t first = 0; first < points_m.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, points_m.size() - first);
    number_voxels(points_m[first].data(), 3 * count, leaf_m, numbers.data());
    for (std::size_t i = 0; i < count; ++i) {
      Voxel& voxel = table.at({static_cast<std::int32_t>(numbers[3 * i]),
                               static_cast<std::int32_t>(numbers[3 * i + 1]),
                               static_cast<std::int32_t>(numbers[3 * i + 2])});
      ++voxel.count;
      voxel.sum_m += points_m[first + i];
    }
  }
  const std::vector<Voxel> voxels = table.take();
  std::vector<Eigen::Vector3d> centroids_m;
  centroids_m.reserve(voxels.size());
  for (const Rank& rank : order_of(voxels)) {
    const Voxel& voxel = voxels[rank.voxel];
    centroids_m.push_back(voxel.sum_m / static_cast<double>(voxel.count));
  }
  return centroids_m;
}

}  // namespace sightline
