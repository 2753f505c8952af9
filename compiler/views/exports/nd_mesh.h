#pragma once

#include <cstddef>
#include <vector>

#include "formats/surroundings/ndt_map.h"

namespace sightline {

inline constexpr std::size_t kEllipsoidVertices = 42;
inline constexpr std::size_t kEllipsoidFaces = 80;

// Binary PLY of a triangle mesh in the frame of exports, m: an ellipsoid at two standard deviations
// for each ND, in the map's order, made of an icosahedron divided once. Colour is the ND's class:
// line orange, plane blue, volume grey.
std::vector<std::byte> nd_ellipsoids_ply(const NdtMap& map);

}  // namespace sightline
