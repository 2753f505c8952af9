#pragma once

#include <string_view>

#include "compiler/base/result.h"

// Where on the Earth a recording in UTM coordinates lies.

namespace sightline {

struct UtmZone {
  int number = 0;  // 1 to 60
  bool is_south = false;
};

// "33N", "19S" (the hemisphere, no latitude band). Error: bad-argument.
Result<UtmZone> parse_utm_zone(std::string_view text);

struct LongitudeLatitude {  // degrees, WGS 84
  double longitude_deg = 0.0;
  double latitude_deg = 0.0;
};

// Off by less than 1 mm within 1000 km of the zone's middle meridian: C. F. F. Karney, Transverse
// Mercator with an accuracy of a few nanometers (2011), equations 15 and 35 with the series of
// order 4 in the flattening.
LongitudeLatitude from_utm(const UtmZone& zone, double easting_m, double northing_m);

}  // namespace sightline
