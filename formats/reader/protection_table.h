#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

// How wrong a pose may be, by kind of place: "Protection levels" in schemas/definitions.md. The
// table ships with the program. It was calibrated on generated worlds, not on real streets.

namespace sightline {

// Order of axes: forward, left, up, yaw.
inline constexpr std::size_t kProtectionAxes = 4;
using ProtectionFactors = std::array<double, kProtectionAxes>;

inline constexpr double kUnavailable = std::numeric_limits<double>::infinity();

struct ProtectionRow {
  std::string_view place;
  std::uint32_t block_count = 0;  // of 60 m that calibrated it
  // What the covariance of a match is multiplied by before the start is used.
  double covariance_factor = 1.0;
  // |error| / sigma of an axis that at most one block in 100 exceeds; infinity: too few blocks.
  ProtectionFactors percent_factors = {kUnavailable, kUnavailable, kUnavailable, kUnavailable};
  // Error that at most one block in 100 exceeds, for a tracking start; m and rad.
  ProtectionFactors percent_errors = {kUnavailable, kUnavailable, kUnavailable, kUnavailable};
  // Below either, a match is doubtful: 0.9 times the likelihood, and the share less 0.05, that all
  // but one good match in 200 exceed.
  double least_likelihood = 0.0;
  double least_scored_share = 0.0;
  // Of the raised points of successive scans that the map has: 0.95 times the least of all good
  // drives, and at most one half.
  double least_raised_share = 0.0;
};

// The groups of kinds of place that have a row, and last the row of all of them.
enum class PlaceGroup : std::uint8_t { kStreet, kTunnel, kOpenRoad, kField, kAny };
inline constexpr std::size_t kPlaceGroups = 5;

// By the number of the column `place_kind` of a map's sites. A kind that was not calibrated, and an
// unknown one, has the row of all places.
PlaceGroup group_of_kind(unsigned place_kind);
const ProtectionRow& protection_row(PlaceGroup group);

// The factors for a risk per 60 m and axis: those of 1e-2 for larger ones too. A smaller risk needs
// more blocks than there are: all infinity.
ProtectionFactors protection_factors(const ProtectionRow& row, double risk);

}  // namespace sightline
