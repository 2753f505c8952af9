#pragma once

#include <optional>
#include <string>

#include "formats/picture/ndt_picture.h"
#include "formats/sites.h"
#include "formats/surface.h"

namespace sightline {

// The whole map from above in one picture of greys (formats/picture/relief.h).
struct Overview {
  MapBox box;
  double pixel_m = 0.0;
  std::string png_base64;
};

// None where there is no surface.
std::optional<Overview> relief_overview(const Surface& surface, const Sites& sites,
                                        double sensor_height_m);

}  // namespace sightline
