#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formats/sites.h"
#include "formats/surface.h"

// Where rays meet a surface. The home of Embree: nothing else in passes/ knows it.

namespace sightline {

// Directions of unit length in map axes.
using Directions = std::vector<Eigen::Vector3d>;

// Sites that share one scene: those in one square of the plane, and the discs that their rays can
// reach. Squares are fixed (64 m), so that no result depends on how a map is cut into tiles.
struct SiteBlock {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // a corner of the square
  std::vector<std::size_t> sites;                      // ascending
  std::vector<std::uint32_t> discs;                    // ascending by key
};
std::vector<SiteBlock> blocks_of_sites(const Sites& sites, const Surface& surface, double reach_m);

// Casts rays on the discs of one block. Both faces count.
class SurfaceCaster {
 public:
  SurfaceCaster(const Surface& surface, const SiteBlock& block);
  ~SurfaceCaster();
  SurfaceCaster(const SurfaceCaster&) = delete;
  SurfaceCaster& operator=(const SurfaceCaster&) = delete;

  // distance_m[i] becomes the distance along directions[i] from p_map_m to the first hit between
  // near_m and far_m, +inf where there is none. Embree finds the disc in float; the distance to the
  // disc's plane is computed in double. Safe from several threads.
  void cast(const Eigen::Vector3d& p_map_m, const Directions& directions, double near_m,
            double far_m, std::span<double> distance_m) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
  const Surface& surface_;
  const SiteBlock& block_;
};

}  // namespace sightline
