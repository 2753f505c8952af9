#pragma once

#include <optional>
#include <string>

#include "compiler/views/picture/ndt_picture.h"
#include "formats/annotation/sites.h"
#include "formats/surroundings/surface.h"

namespace sightline {

// The whole map from above in one picture of greys (compiler/views/picture/relief.h).
struct Overview {
  MapBox box;
  double pixel_m = 0.0;
  std::string png_base64;
};

// None where there is no surface.
std::optional<Overview> relief_overview(const Surface& surface, const Sites& sites,
                                        double sensor_height_m);

}  // namespace sightline
