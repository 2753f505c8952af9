#include "passes/matching/voxel_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>

#include "compiler/base/check.h"
#include "formats/cell_index.h"

// A table with a place for every cell of the box needs no comparing and no sorting. What would make
// it slow is filling it with zeros, so a bit says whether a place was ever written, and the bits,
// read from the first, give the voxels in the order of their keys.

namespace sightline {
namespace {

struct Voxel {
  Eigen::Vector3d sum_m;
  double count;
};

std::int64_t width(std::int32_t low, std::int32_t high) {
  return static_cast<std::int64_t>(high) - low + 1;
}

class VoxelTable {
 public:
  VoxelTable(const VoxelBox& box, std::size_t point_count)
      : low_(box.low),
        y_width_(width(box.low.y, box.high.y)),
        z_width_(width(box.low.z, box.high.z)),
        bits_(static_cast<std::size_t>(cell_count(box)) / 64 + 1),
        numbers_(new std::uint32_t[static_cast<std::size_t>(cell_count(box))]),
        voxels_(new Voxel[point_count]) {}

  void add(const CellKey& key, const Eigen::Vector3d& point_m) {
    const auto cell = static_cast<std::size_t>(
        ((key.x - low_.x) * y_width_ + (key.y - low_.y)) * z_width_ + (key.z - low_.z));
    std::uint64_t& word = bits_[cell / 64];
    const std::uint64_t bit = std::uint64_t{1} << cell % 64;
    if ((word & bit) == 0) {
      word |= bit;
      numbers_[cell] = count_;
      voxels_[count_++] = {Eigen::Vector3d::Zero() + point_m, 1.0};  // as sums begin: no -0
      return;
    }
    Voxel& voxel = voxels_[numbers_[cell]];
    voxel.sum_m += point_m;
    voxel.count += 1.0;
  }

  [[nodiscard]] std::vector<Eigen::Vector3d> centroids_m() const {
    std::vector<Eigen::Vector3d> centroids_m;
    centroids_m.reserve(count_);
    for (std::size_t i = 0; i < bits_.size(); ++i) {
      for (std::uint64_t word = bits_[i]; word != 0; word &= word - 1) {
        const Voxel& voxel =
            voxels_[numbers_[64 * i + static_cast<std::size_t>(std::countr_zero(word))]];
        centroids_m.push_back(voxel.sum_m / voxel.count);
      }
    }
    return centroids_m;
  }

 private:
  CellKey low_;
  std::int64_t y_width_;
  std::int64_t z_width_;
  std::vector<std::uint64_t> bits_;           // of cells: is there a voxel?
  std::unique_ptr<std::uint32_t[]> numbers_;  // of voxels, where there is one
  std::unique_ptr<Voxel[]> voxels_;           // in the order in which they were met
  std::uint32_t count_ = 0;
};

}  // namespace

double cell_count(const VoxelBox& box) {
  return static_cast<double>(width(box.low.x, box.high.x)) *
         static_cast<double>(width(box.low.y, box.high.y)) *
         static_cast<double>(width(box.low.z, box.high.z));
}

std::vector<Eigen::Vector3d> centroids_by_table(std::span<const Eigen::Vector3d> points_m,
                                                double leaf_m, const VoxelBox& box) {
  SIGHTLINE_CHECK(cell_count(box) <= kMostTableCells);
  constexpr std::size_t kChunk = 512;
  std::array<CellKey, kChunk> keys;
  VoxelTable table(box, points_m.size());
  for (std::size_t first = 0; first < points_m.size(); first += kChunk) {
    const std::span<const Eigen::Vector3d> chunk_m =
        points_m.subspan(first, std::min(kChunk, points_m.size() - first));
    cell_keys(chunk_m, leaf_m, std::span(keys).first(chunk_m.size()));
    for (std::size_t i = 0; i < chunk_m.size(); ++i) table.add(keys[i], chunk_m[i]);
  }
  return table.centroids_m();
}

}  // namespace sightline
