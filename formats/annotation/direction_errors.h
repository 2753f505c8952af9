#pragma once

#include <span>

#include "formats/record/fields.h"

// Errors of matches in the vehicle's axes ("Errors by direction" in schemas/definitions.md).

namespace sightline {

// One start of the matcher relative to the reference pose, in the vehicle's frame.
struct InitialOffset {
  double x_m = 0.0;
  double y_m = 0.0;
  double z_m = 0.0;
  double yaw_rad = 0.0;
};
SIGHTLINE_FIELDS(InitialOffset, x_m, y_m, z_m, yaw_rad)

// Where a match ended relative to the reference pose, in the axes of the vehicle at that pose: x
// forward, y left, z up. Also a figure of each of these axes.
struct AxisErrors {
  float longitudinal_m = 0.0F;
  float lateral_m = 0.0F;
  float height_m = 0.0F;
  float yaw_rad = 0.0F;
  friend bool operator==(const AxisErrors&, const AxisErrors&) = default;
};
SIGHTLINE_FIELDS(AxisErrors, longitudinal_m, lateral_m, height_m, yaw_rad)

// Of the matches of one scan from several starts.
struct DirectionErrors {
  AxisErrors mean;       // signed
  AxisErrors deviation;  // standard deviation over the starts (divided by their number)
  // Share of the start's offset that remains at the end: slope of the linear regression of end on
  // start, each axis by itself, no unit. 0 where the starts do not differ on the axis.
  AxisErrors kept;
};
SIGHTLINE_FIELDS(DirectionErrors, mean, deviation, kept)

// An end for each start. Zeros where there is none.
DirectionErrors direction_errors(std::span<const InitialOffset> starts,
                                 std::span<const AxisErrors> ends);

}  // namespace sightline
