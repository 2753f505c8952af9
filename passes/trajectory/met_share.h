#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"

// Whether a scan shows a map at a pose, by what is upright in both ("Drives beside a map" in
// schemas/definitions.md).

namespace sightline {

// The NDs of a map, found by place. Refers to the map.
class NdsByCell {
 public:
  explicit NdsByCell(const NdtMap& map);

  // Calls visit(nd) for those of the point's cell and of the six beside it.
  template <class Visit>
  void visit_near(const Eigen::Vector3d& point_map_m, const Visit& visit) const {
    static constexpr std::array<std::array<int, 3>, 7> kSteps = {
        {{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};
    const CellKey key = cell_key(point_map_m, cell_m_);
    for (const std::array<int, 3>& step : kSteps) {
      const Nd* const* nd = cells_.find({key.x + step[0], key.y + step[1], key.z + step[2]});
      if (nd != nullptr) visit(**nd);
    }
  }

 private:
  double cell_m_;
  CellTable<const Nd*> cells_;
};

// Whether an ND identifies a place: a wall or a pole.
bool identifies_place(const Nd& nd);

// Whether a point is on the surface or the line of an ND, near the returns that it is of.
bool meets(const Nd& nd, const Eigen::Vector3d& point_map_m);

// Share of upright points (upright_points) that meet walls and poles, without those in foliage and
// the like. None where fewer than 30 can be compared.
std::optional<double> met_share(const NdsByCell& nds, std::span<const Eigen::Vector3d> upright_m,
                                const Pose& T_map_points);

}  // namespace sightline
