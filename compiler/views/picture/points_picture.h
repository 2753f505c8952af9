#pragma once

#include "compiler/views/picture/raster.h"
#include "formats/base/result.h"
#include "formats/surroundings/surface_points.h"

namespace sightline {

// The points from above, north up, one pixel for each 0.2 m and coarser where the picture would be
// wider than 4000 pixels: the more that stands in a pixel the darker its grey; red where something
// was removed. Errors: bad-argument (no points), and what reading a scan says.
Result<Raster> points_picture(const SurfacePoints& points);

}  // namespace sightline
