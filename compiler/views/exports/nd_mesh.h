#pragma once

#include <cstddef>

#include "formats/base/bytes.h"
#include "formats/base/result.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

inline constexpr std::size_t kEllipsoidVertices = 42;
inline constexpr std::size_t kEllipsoidFaces = 80;

// Binary PLY of a triangle mesh in the frame of exports, m: an ellipsoid at two standard deviations
// for each ND, in the map's order, made of an icosahedron divided once. Colour is the ND's class:
// line orange, plane blue, volume grey. It is ten times as large as the map, so it comes in pieces.
// Errors: those of the sink.
Result<void> write_nd_ellipsoids(const NdtMap& map, const ByteSink& sink);

}  // namespace sightline
