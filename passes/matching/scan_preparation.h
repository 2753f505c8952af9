#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace sightline {

// A scan laid out so that the crop at every range is a prefix. Points keep their order within the
// shell between two ranges; those beyond the longest range are left out.
struct ShelledScan {
  std::vector<Eigen::Vector3d> points_m;  // sensor frame
  std::vector<std::size_t> counts;        // points with |x| <= range, for each range

  [[nodiscard]] std::span<const Eigen::Vector3d> crop(std::size_t range) const {
    return std::span(points_m).first(counts[range]);
  }
};
// `ranges_m` ascending.
ShelledScan sort_into_shells(std::span<const Eigen::Vector3d> points_m,
                             std::span<const double> ranges_m);

// One centroid for each voxel floor(x / leaf) that holds a point, ascending by voxel key (x, then
// y, then z). Points must be finite and within 2^31 voxels of the origin.
std::vector<Eigen::Vector3d> voxel_subsample(std::span<const Eigen::Vector3d> points_m,
                                             double leaf_m);

}  // namespace sightline
