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

inline constexpr std::size_t kEllipsoidVertices = 42;
inline constexpr std::size_t kEllipsoidFaces = 80;

// Binary PLY of a triangle mesh in the frame of exports, m: an ellipsoid at two standard deviations
// for each ND, in the map's order, made of an icosahedron divided once. Colour is the ND's class:
// line orange, plane blue, volume grey. It is ten times as large as the map, so it comes in pieces.
// Errors: those of the sink.
Result<void> write_nd_ellipsoids(const NdtMap& map, const ByteSink& sink);

}  // namespace sightline
