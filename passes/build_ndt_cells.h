#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "formats/ndt_map.h"

// The cells of one tile while points are added to them; part of build-ndt.

namespace sightline {

inline Eigen::Vector3d cell_centre_m(const CellKey& key, double cell_m) {
  return {(key.x + 0.5) * cell_m, (key.y + 0.5) * cell_m, (key.z + 0.5) * cell_m};
}

// Moments about the cell's centre: far from the origin they keep the digits that matter.
struct CellSums {
  CellKey key;
  std::uint32_t count = 0;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;

  void add(const Eigen::Vector3d& from_centre_m) {
    const double x = from_centre_m.x();
    const double y = from_centre_m.y();
    const double z = from_centre_m.z();
    ++count;
    sum_m += from_centre_m;
    xx += x * x;
    xy += x * y;
    xz += x * z;
    yy += y * y;
    yz += y * z;
    zz += z * z;
  }
};

// Cells of one tile by key: open addressing over indices into `cells`.
class CellTable {
 public:
  CellTable() : slots_(kFirstSize, kFree) {}

  CellSums& at(const CellKey& key) {
    // Neighbours in a scan often share a cell.
    if (last_ < cells_.size() && cells_[last_].key == key) return cells_[last_];
    std::size_t slot = hash(key) & (slots_.size() - 1);
    while (slots_[slot] != kFree && cells_[slots_[slot]].key != key) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    if (slots_[slot] == kFree) {
      slots_[slot] = static_cast<std::uint32_t>(cells_.size());
      cells_.emplace_back().key = key;
      last_ = cells_.size() - 1;
      if (2 * cells_.size() > slots_.size()) grow();
    } else {
      last_ = slots_[slot];
    }
    return cells_[last_];
  }

  // Ascending by key; the table is empty afterwards.
  std::vector<CellSums> take();

 private:
  static constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::size_t kFirstSize = 1024;

  static std::size_t hash(const CellKey& key) {
    const std::uint64_t mixed = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ULL ^
                                static_cast<std::uint32_t>(key.y) * 0xbf58476d1ce4e5b9ULL ^
                                static_cast<std::uint32_t>(key.z) * 0x94d049bb133111ebULL;
    return static_cast<std::size_t>(mixed >> 32);
  }

  void grow();

  std::vector<CellSums> cells_;
  std::vector<std::uint32_t> slots_;
  std::size_t last_ = 0;
};

// The ND of a cell of at least two points: covariance divided by n - 1, mean kept inside the cell.
Nd nd_of(const CellSums& sums, double cell_m);

}  // namespace sightline
