#include "passes/matching/scan_preparation.h"

#include <algorithm>
#include <bit>
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

std::size_t hash(const CellKey& key) {
  const std::uint64_t mixed = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ULL ^
                              static_cast<std::uint32_t>(key.y) * 0xbf58476d1ce4e5b9ULL ^
                              static_cast<std::uint32_t>(key.z) * 0x94d049bb133111ebULL;
  return static_cast<std::size_t>(mixed >> 32);
}

// Index of the shell that holds a squared distance; ranges.size() beyond the longest.
std::size_t shell_of(double distance2_m2, std::span<const double> ranges_m) {
  std::size_t shell = 0;
  while (shell < ranges_m.size() && distance2_m2 > ranges_m[shell] * ranges_m[shell]) ++shell;
  return shell;
}

// Voxels in the order of their first points.
std::vector<Voxel> collect_voxels(std::span<const Eigen::Vector3d> points_m, double leaf_m) {
  constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> slots(std::bit_ceil(2 * points_m.size() + 1), kFree);
  const std::size_t mask = slots.size() - 1;
  std::vector<Voxel> voxels;
  for (const Eigen::Vector3d& point_m : points_m) {
    const CellKey key = cell_key(point_m, leaf_m);
    std::size_t slot = hash(key) & mask;
    while (slots[slot] != kFree && voxels[slots[slot]].key != key) slot = (slot + 1) & mask;
    if (slots[slot] == kFree) {
      slots[slot] = static_cast<std::uint32_t>(voxels.size());
      voxels.emplace_back().key = key;
    }
    Voxel& voxel = voxels[slots[slot]];
    ++voxel.count;
    voxel.sum_m += point_m;
  }
  return voxels;
}

}  // namespace

ShelledScan sort_into_shells(std::span<const Eigen::Vector3d> points_m,
                             std::span<const double> ranges_m) {
  std::vector<std::uint16_t> shells(points_m.size());
  std::vector<std::size_t> sizes(ranges_m.size() + 1, 0);
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const std::size_t shell = shell_of(points_m[i].squaredNorm(), ranges_m);
    shells[i] = static_cast<std::uint16_t>(shell);
    ++sizes[shell];
  }
  ShelledScan scan;
  std::vector<std::size_t> next(ranges_m.size() + 1, 0);
  for (std::size_t shell = 0; shell < ranges_m.size(); ++shell) {
    next[shell + 1] = next[shell] + sizes[shell];
    scan.counts.push_back(next[shell + 1]);
  }
  scan.points_m.resize(next.back());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (shells[i] < ranges_m.size()) scan.points_m[next[shells[i]]++] = points_m[i];
  }
  return scan;
}

std::vector<Eigen::Vector3d> voxel_subsample(std::span<const Eigen::Vector3d> points_m,
                                             double leaf_m) {
  std::vector<Voxel> voxels = collect_voxels(points_m, leaf_m);
  std::sort(voxels.begin(), voxels.end(),
            [](const Voxel& a, const Voxel& b) { return a.key < b.key; });
  std::vector<Eigen::Vector3d> centroids_m;
  centroids_m.reserve(voxels.size());
  for (const Voxel& voxel : voxels) {
    centroids_m.push_back(voxel.sum_m / static_cast<double>(voxel.count));
  }
  return centroids_m;
}

}  // namespace sightline
