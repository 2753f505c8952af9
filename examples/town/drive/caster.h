#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>

#include "examples/town/world/mesh.h"

// Rays against the exact triangles of a town.

namespace sightline::town {

struct Hit {
  double range_m = std::numeric_limits<double>::infinity();  // nothing hit
  double cosine = 0.0;  // between the ray and the surface's normal, 0 to 1
  Label label = Label::kGround;

  [[nodiscard]] bool is_hit() const { return range_m < std::numeric_limits<double>::infinity(); }
};

// The point of the triangles that is nearest to another one.
struct Surface {
  bool is_found = false;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of unit length
};

// Owns a tree of boxes over a copy of the triangles. Casting is safe from several threads.
class TownCaster {
 public:
  explicit TownCaster(const TownMesh& mesh);
  ~TownCaster();
  TownCaster(const TownCaster&) = delete;
  TownCaster& operator=(const TownCaster&) = delete;

  // First hit of a ray of unit direction, both faces of every triangle counting, at any range; of
  // triangles equally near the first one of the mesh. Decided and computed in double: the same on
  // every processor.
  [[nodiscard]] Hit cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const;

  // The range alone; infinity where nothing is hit.
  [[nodiscard]] double exact_range_m(const Eigen::Vector3d& origin_m,
                                     const Eigen::Vector3d& direction) const {
    return cast(origin_m, direction).range_m;
  }

  // Within that distance; of triangles equally near the first one of the mesh.
  [[nodiscard]] Surface nearest_surface(const Eigen::Vector3d& point_m, double within_m) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sightline::town
