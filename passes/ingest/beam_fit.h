#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/foreign/clouds/point_cloud_file.h"

// What the elevations of returns say of the beams that they came from.

namespace sightline {

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
