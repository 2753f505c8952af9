#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"

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

// The directions in which the points of one ND are measured.
struct Structure {
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // the shortest axis
  Eigen::Vector3d across = Eigen::Vector3d::UnitX();  // of a line: its other axis across it
  double normal_m2 = 0.0;                             // variances of the points along these
  double across_m2 = 0.0;
  double shared_m2 = 0.03 * 0.03;  // variance of errors that do not average out over points
  double farthest_m = 0.25;        // off the surface: points farther off belong to something else
  int direction_count = 0;         // 0: constrains nothing; 1: a surface; 2: a line
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
// schemas/definitions.md, v1). Cells of one pole share its error. A cell with more than one
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

// The structures of a map, by cell; NDs that constrain nothing are left out. Costs time and memory
// in proportion to the number of NDs.
class StructureMap {
 public:
  StructureMap() = default;
  explicit StructureMap(const NdtMap& map);

  static constexpr std::uint32_t kNone = CellIndex::kNone;
  // Of the structure in a cell; kNone where there is none.
  [[nodiscard]] std::uint32_t number_of(const CellKey& cell) const {
    return structures_.number_of(cell);
  }
  [[nodiscard]] const Structure& at(std::uint32_t number) const {
    return structures_.values()[number];
  }
  // Bring nearer what number_of() and at() look into.
  void prefetch(const CellKey& cell) const { structures_.prefetch(cell); }
  void prefetch(std::uint32_t number) const {
    const char* const begin = reinterpret_cast<const char*>(&at(number));
    __builtin_prefetch(begin);
    __builtin_prefetch(begin + sizeof(Structure) - 1);
  }
  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] std::size_t size() const { return structures_.size(); }

 private:
  double cell_m_ = 2.0;
  CellTable<Structure> structures_;
};

}  // namespace sightline
