#pragma once

#include "formats/geometry.h"
#include "formats/reader/protection_table.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/matcher.h"

// How far off a pose may be, and whether its match is like the good ones of such places
// ("Protection levels" and "Integrity of a match" in schemas/definitions.md).

namespace sightline {

// Forward, left and up of the vehicle, m; yaw, rad. Infinity: unavailable.
ProtectionFactors protection_levels(const PoseEstimate& estimate, const ProtectionRow& row,
                                    double risk);

enum class Integrity : std::uint8_t { kUnknown, kOk, kDoubtful, kLost };

// Of one match of so many points, whatever came before: doubtful where its likelihood or its share
// of scored points is below that of good matches at such a place. Unknown where nothing was
// matched.
Integrity integrity_of(const MatchResult& found, std::size_t point_count, const ProtectionRow& row);

// A sequential test over the matches of successive scans. It counts doubtful ones up and others
// down, and gives kDoubtful from 2 on and kLost from 4 on; at most 6, so that a vehicle that is
// found again is ok after 5 good scans. It also sums raised points, those of earlier scans with
// weights that fall by a tenth with each scan, and gives at least kDoubtful while the map has fewer
// of them than it has at the good matches of such a place. Copy it freely; it allocates nothing.
struct IntegrityMonitor {
  std::uint32_t doubt = 0;
  double raised_count = 0.0;
  double raised_met_count = 0.0;

  Integrity add(Integrity match, const RaisedPoints& raised, const ProtectionRow& row);
  // Of the sums. A few points show nothing: as if eight more had been met.
  [[nodiscard]] double raised_met_share() const;
};

}  // namespace sightline
