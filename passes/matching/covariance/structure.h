#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/grid/match_grid.h"

// What in a map constrains a match: surfaces along their normals, upright lines (poles, trunks)
// across their axes. Rings on the ground and along walls, ends of cells and foliage do not
// ("Constraints of a match" and "Covariance of a match" in schemas/definitions.md).

namespace sightline {

// Whether an ND is a surface, or an upright line, in this sense.
bool is_surface(const Nd& nd);
bool is_upright_line(const Nd& nd);

// Whether an ND is wide, and not much thinner than wide.
bool is_thick_surface(const Nd& nd);

// Whether a line is the end of the surface `beside` it, cut off by its cell.
bool ends_surface(const Nd& line, const Nd& beside);

// The directions in which the points of one ND are measured. What each point needs comes first, in
// one line of the cache.
struct alignas(64) Structure {
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // the shortest axis
  double farthest_m = 0.25;  // off the surface: points farther off belong to something else
  int direction_count = 0;   // 0: constrains nothing; 1: a surface; 2: a line
  double normal_m2 = 0.0;    // variances of the points along these
  double across_m2 = 0.0;
  double shared_m2 = 0.03 * 0.03;  // variance of errors that do not average out over points
  Eigen::Vector3d across = Eigen::Vector3d::UnitX();  // of a line: its other axis across it
};

// Of an ND. `nd_at(CellKey)` returns the ND of a cell, a pointer that is null where there is none.
template <class NdAt>
Structure structure_of(const Nd& nd, const NdAt& nd_at) {
  Structure structure;
  structure.mean_m = nd.mean_m;
  structure.normal = nd.eigenvectors.col(2);
  structure.across = nd.eigenvectors.col(1);
  structure.normal_m2 = nd.eigenvalues_m2[2];
  structure.across_m2 = nd.eigenvalues_m2[1];
  if (is_surface(nd)) {
    structure.direction_count = 1;
    return structure;
  }
  if (!is_upright_line(nd)) return structure;
  for (std::int32_t x = -1; x <= 1; ++x) {
    for (std::int32_t y = -1; y <= 1; ++y) {
      if (x == 0 && y == 0) continue;
      const Nd* const beside = nd_at(CellKey{nd.key.x + x, nd.key.y + y, nd.key.z});
      if (beside != nullptr && ends_surface(nd, *beside)) return structure;
    }
  }
  structure.direction_count = 2;
  return structure;
}

// Of an ND of a map of several scans, whose ground is no rings ("Covariance of a match" in
// schemas/definitions.md). Cells of one pole share its error. A cell with more than one
// surface, as ground and a guard rail, is a surface that is as wrong as it is thick.
template <class NdAt>
Structure map_structure_of(const Nd& nd, const NdAt& nd_at) {
  constexpr double kPole_m = 0.06;
  Structure structure = structure_of(nd, nd_at);
  if (structure.direction_count == 2) structure.shared_m2 = kPole_m * kPole_m;
  if (structure.direction_count == 0 && is_thick_surface(nd)) {
    structure.direction_count = 1;
    structure.shared_m2 += nd.eigenvalues_m2[2];
    structure.farthest_m = std::max(structure.farthest_m, 2.0 * std::sqrt(nd.eigenvalues_m2[2]));
  }
  return structure;
}

// The structures of a map; NDs that constrain nothing are left out. Costs time and memory in
// proportion to the number of NDs.
class StructureMap {
 public:
  StructureMap() = default;
  // `grid`: of the NDs of `map`, as the last level of a localizer.
  StructureMap(const NdtMap& map, std::shared_ptr<const MatchGrid> grid);
  // With a grid of its own.
  explicit StructureMap(const NdtMap& map);

  static constexpr std::uint32_t kNone = 0xffffffffU;
  static constexpr std::uint32_t kConstrainsNothing = 0xfffffffeU;
  static bool is_structure(std::uint32_t number) { return number < kConstrainsNothing; }
  // Of the structure in the cell with that record, 0 and up. kConstrainsNothing: its ND is none.
  // kNone: it has no ND.
  [[nodiscard]] std::uint32_t number_of_record(std::int32_t record) const {
    return numbers_[static_cast<std::size_t>(record)];
  }
  [[nodiscard]] const Structure& at(std::uint32_t number) const { return structures_[number]; }
  // Bring nearer what these look into.
  void prefetch_record(std::int32_t record) const {
    __builtin_prefetch(&numbers_[static_cast<std::size_t>(record)]);
  }
  void prefetch(std::uint32_t number) const {
    const char* const begin = reinterpret_cast<const char*>(&at(number));
    __builtin_prefetch(begin);
    __builtin_prefetch(begin + 64);
  }
  [[nodiscard]] const MatchGrid& grid() const { return *grid_; }
  [[nodiscard]] std::size_t size() const { return structures_.size(); }

 private:
  std::shared_ptr<const MatchGrid> grid_;
  std::vector<std::uint32_t> numbers_;  // by record
  std::vector<Structure> structures_;   // in the order of the NDs
};

}  // namespace sightline
