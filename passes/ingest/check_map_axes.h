#pragma once

#include "formats/base/result.h"
#include "formats/surroundings/surface_points.h"

namespace sightline {

// Whether the points of a finished map can be metres with z up. Two measures of up to two million
// points:
// - Unit. The height of objects on the ground, in columns as wide as the points are dense: more
//   than 300 in a map whose points are farther apart than 1 are millimetres or centimetres.
// - Axes. Planar cells of 2 m, by the axis that they face, and whether points are on one side of
//   them alone. Ground has points above and none below; walls face each other. Where another axis
//   has ground and z has not, or z has it from below, the axes are others.
// Error: unsupported-format.
Result<void> check_map_axes(const SurfacePoints& points);

}  // namespace sightline
