#pragma once

#include <optional>
#include <span>
#include <string>

#include "formats/foreign/clouds/point_cloud_file.h"

namespace sightline {

// What some scans of one sensor say of it.
struct SensorGuess {
  std::string profile;  // a built-in one; empty: none fits, and then the three below say what does
  int rings = 0;
  double lowest_beam_deg = 0.0;
  double highest_beam_deg = 0.0;
  // What returns fill of a turn, where that is less than the profile sees; nothing: they fill it.
  std::optional<double> azimuth_view_deg;
  std::string reason;              // one sentence, for the person who checks the guess
  std::optional<double> height_m;  // of the sensor above the ground around it; nothing: not seen
};

// Judges by the elevations of the returns: beams that stand where a profile's stand, or, where
// elevations are smeared (the beams leave the sensor at several heights, or motion was taken out),
// a span like that of a profile. A sensor that does not see all round is known by the width of its
// view and by the span of its returns lying within its beams'. Scans in a frame other than the
// sensor's fit no profile.
SensorGuess guess_sensor(std::span<const PointCloudFile> scans);

}  // namespace sightline
