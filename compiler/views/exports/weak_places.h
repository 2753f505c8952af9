#pragma once

#include <Eigen/Core>
#include <vector>

#include "formats/grid/point_grid.h"
#include "formats/map/compiled_map.h"
#include "passes/weakness/weak_stretches.h"

namespace sightline {

// Where a map is weak (weak_stretches.h), for places beside its sites.
class WeakPlaces {
 public:
  // Nowhere.
  WeakPlaces() = default;
  // Of the limit that the options name. Error: bad-argument (no limit of the map).
  static Result<WeakPlaces> of(const CompiledMap& map, const WeakStretchOptions& options);

  // Whether the site nearest to a sensor there belongs to a weak stretch; world coordinates.
  [[nodiscard]] bool is_weak(const Eigen::Vector3d& sensor_world_m) const;

 private:
  Eigen::Vector3d origin_world_m_ = Eigen::Vector3d::Zero();
  PointGrid sites_;
  std::vector<bool> is_weak_;  // of each
};

}  // namespace sightline
