#include "compiler/views/exports/weak_places.h"

#include <limits>
#include <optional>

namespace sightline {

Result<WeakPlaces> WeakPlaces::of(const CompiledMap& map, const WeakStretchOptions& options) {
  SIGHTLINE_ASSIGN(const std::size_t limit, limit_of(map, options.limit_m));
  WeakPlaces places;
  places.origin_world_m_ = map.sites.frame.origin_world_m;
  places.sites_ = PointGrid(positions_m(map.sites));
  places.is_weak_.resize(map.sites.sites.size());
  const std::vector<BestLook> best = best_looks(map, limit);
  for (const WeakStretch& stretch : weak_stretches(map.sites, best, options)) {
    for (std::size_t site = stretch.first_site; site <= stretch.last_site; ++site) {
      places.is_weak_[site] = true;
    }
  }
  return places;
}

bool WeakPlaces::is_weak(const Eigen::Vector3d& sensor_world_m) const {
  constexpr double kAnywhere_m = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d p_map_m = sensor_world_m - origin_world_m_;
  const std::optional<NearPoint> site = sites_.nearest(p_map_m, kAnywhere_m);
  return site && is_weak_[site->index];
}

}  // namespace sightline
