#include "passes/matching/voxel_table.h"

#include <algorithm>
#include <array>
#include <bit>

#include "formats/base/check.h"
#include "formats/grid/cell_index.h"

// A table with a place for every cell of the box needs no comparing and no sorting. What would make
// it slow is filling it with zeros, so a bit says whether a place was ever written, and the bits,
// read from the first, give the voxels in the order of their keys. A second row of bits says which
// words of the first are worth reading; reading a word clears it for the next scan.

namespace sightline {
namespace {

constexpr std::size_t kWordBits = 64;

std::int64_t width(std::int32_t low, std::int32_t high) {
  return static_cast<std::int64_t>(high) - low + 1;
}

// Calls use(number) for each bit that is set, ascending, and clears all.
template <class Use>
void take_bits(std::size_t word_index, std::uint64_t& word, const Use& use) {
  for (std::uint64_t left = word; left != 0; left &= left - 1) {
    use(kWordBits * word_index + static_cast<std::size_t>(std::countr_zero(left)));
  }
  word = 0;
}

}  // namespace

double cell_count(const VoxelBox& box) {
  return static_cast<double>(width(box.low.x, box.high.x)) *
         static_cast<double>(width(box.low.y, box.high.y)) *
         static_cast<double>(width(box.low.z, box.high.z));
}

void VoxelTable::begin(const VoxelBox& box) {
  SIGHTLINE_CHECK(cell_count(box) <= kMostTableCells);
  SIGHTLINE_CHECK(voxel_count_ == 0);
  low_ = box.low;
  y_width_ = width(box.low.y, box.high.y);
  z_width_ = width(box.low.z, box.high.z);
  const auto count = static_cast<std::size_t>(cell_count(box));
  if (count <= number_count_) return;
  numbers_.reset(new std::uint32_t[count]);  // without zeros, unlike make_unique
  number_count_ = count;
  bits_.resize(count / kWordBits + 1);
  words_.resize(bits_.size() / kWordBits + 1);
}

// In local variables: the compiler cannot know that adding to a sum leaves the members alone.
void VoxelTable::add_keyed(std::span<const Eigen::Vector3d> points_m,
                           std::span<const CellKey> keys) {
  if (voxels_.size() < voxel_count_ + keys.size()) voxels_.resize(2 * voxel_count_ + keys.size());
  const CellKey low = low_;
  const std::int64_t y_width = y_width_, z_width = z_width_;
  std::uint64_t* const bits = bits_.data();
  std::uint64_t* const words = words_.data();
  std::uint32_t* const numbers = numbers_.get();
  Voxel* const voxels = voxels_.data();
  std::uint32_t voxel_count = voxel_count_;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const CellKey& key = keys[i];
    const auto cell = static_cast<std::size_t>(
        ((key.x - low.x) * y_width + (key.y - low.y)) * z_width + (key.z - low.z));
    const std::size_t index = cell / kWordBits;
    const std::uint64_t bit = std::uint64_t{1} << cell % kWordBits;
    if ((bits[index] & bit) != 0) {
      Voxel& voxel = voxels[numbers[cell]];
      voxel.sum_m += points_m[i];
      voxel.count += 1.0;
      continue;
    }
    bits[index] |= bit;
    words[index / kWordBits] |= std::uint64_t{1} << index % kWordBits;
    numbers[cell] = voxel_count;
    voxels[voxel_count++] = {Eigen::Vector3d::Zero() + points_m[i], 1.0};  // as sums begin: no -0
  }
  voxel_count_ = voxel_count;
}

void VoxelTable::add(std::span<const Eigen::Vector3d> points_m, double leaf_m) {
  constexpr std::size_t kChunk = 512;
  std::array<CellKey, kChunk> keys;
  for (std::size_t first = 0; first < points_m.size(); first += kChunk) {
    const std::span<const Eigen::Vector3d> chunk_m =
        points_m.subspan(first, std::min(kChunk, points_m.size() - first));
    cell_keys(chunk_m, leaf_m, std::span(keys).first(chunk_m.size()));
    add_keyed(chunk_m, std::span(keys).first(chunk_m.size()));
  }
}

std::vector<Eigen::Vector3d> VoxelTable::take_centroids_m() {
  std::vector<Eigen::Vector3d> centroids_m;
  centroids_m.reserve(voxel_count_);
  const auto take_cell = [&](std::size_t cell) {
    const Voxel& voxel = voxels_[numbers_[cell]];
    centroids_m.push_back(voxel.sum_m / voxel.count);
  };
  for (std::size_t i = 0; i < words_.size(); ++i) {
    take_bits(i, words_[i], [&](std::size_t index) { take_bits(index, bits_[index], take_cell); });
  }
  voxel_count_ = 0;
  return centroids_m;
}

}  // namespace sightline
