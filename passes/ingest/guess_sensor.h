#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

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

// Up to five of `scan_count` scans, ascending: first, last and some between. What is wrong with a
// recording mostly shows in them.
std::vector<std::size_t> sample_scans(std::size_t scan_count);

// Of the returns 3 m and farther from the sensor, in its frame, degrees, ascending. Nearer than
// that the offsets between a sensor's beams bend elevations, and it sees its vehicle.
std::vector<double> elevations_deg(std::span<const PointCloudFile> scans);

// Where returns begin and end, without the 0.2 % farthest to either side: stray ones are few.
// There is at least one.
struct BeamSpan {
  double lowest_deg = 0.0;
  double highest_deg = 0.0;
};
BeamSpan span_of(const std::vector<double>& elevations);

// "-15.0 to 15.0 degrees"
std::string to_text(const BeamSpan& span);

// How wide a sector about the sensor's +x axis holds its returns 3 m and farther away but for the
// 0.2 % farthest outside, degrees, in tenths. 360: they lie all round, or are too few to tell.
double azimuth_view_deg(std::span<const PointCloudFile> scans);

// How elevations lie among beams.
struct BeamFit {
  double off = 1.0;     // mean distance to the nearest beam, in gaps between beams; 0.25 by chance
  double inside = 0.0;  // share of returns within half a gap of a beam
  double hit = 0.0;     // share of beams with returns

  // Returns stand at these beams, and at no others.
  [[nodiscard]] bool is_crisp() const { return off <= 0.15 && inside >= 0.9 && hit >= 0.8; }
};

// Of elevations and at least two beams, both ascending.
BeamFit fit_beams(const std::vector<double>& elevations, const std::vector<double>& beams_deg);

}  // namespace sightline
