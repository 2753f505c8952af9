#pragma once

#include <cstddef>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/result.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface_points.h"

namespace sightline {

// What stood still, thinned to one centroid in each cubic voxel of leaf_m (0: every point), in map
// coordinates; ascending by voxel (x, y, z), points of 0 in their own order. Errors: what reading a
// scan says, bad-value (a leaf below 0).
Result<std::vector<Eigen::Vector3d>> thinned_points(const SurfacePoints& surface, double leaf_m);

// PLY of points (binary, double x y z), as they are.
std::vector<std::byte> points_ply(const std::vector<Eigen::Vector3d>& points_m);

inline constexpr std::size_t kGaussianBytes = 59;

// Binary PLY of the NDs as Gaussians, in the map's order and in the frame of exports: mean x y z
// (m), scale_0..2 (natural logarithms of the standard deviations along its axes, m), rot_0..3
// (quaternion w x y z from its axes to the frame), f_dc_0..2, opacity and red green blue (its
// class: line orange, plane blue, volume grey). Viewers of Gaussian splats draw it; others read
// coloured points. kGaussianBytes an ND. Errors: those of the sink.
Result<void> write_nd_gaussians(const NdtMap& map, const ByteSink& sink);

}  // namespace sightline
