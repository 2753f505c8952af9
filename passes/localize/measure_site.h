#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/localize/site_localizer.h"

namespace sightline {

// A match that ended farther off counts as lost.
inline constexpr double kLostBeyond_m = 0.5;

// What all sites of measure-error share.
struct SiteMeasuring {
  ErrorReference reference = ErrorReference::kKnownPose;
  const Drive& drive;
  const Trajectory& trajectory;  // in the map's frame
  const std::vector<InitialOffset>& offsets;
  std::vector<Look> looks;    // of every return
  std::vector<Look> samples;  // looks that take a sample
  std::uint64_t seed = 0;
};

// Rows of sites in their order, each one's looks in theirs.
struct SiteRows {
  std::vector<ErrorRow> rows;     // of SiteMeasuring::looks
  std::vector<ErrorRow> samples;  // of SiteMeasuring::samples
};

// A scan, where the vehicle was, and the pose that the scan came with.
struct ReferencedScan {
  const Scan& scan;
  Pose T_map_reference = Pose::Identity();
  Pose T_map_given = Pose::Identity();
};

// Appends the rows of one scan, which is matched by each look from every offset.
void measure_scan(const std::vector<InitialOffset>& offsets, const std::vector<Look>& looks,
                  const ReferencedScan& scan, SiteLocalizer& localizer,
                  std::vector<ErrorRow>& rows);

// Appends the rows of one site: its scan is matched at every look from every offset and compared
// with the reference. Error: what reading the scan returns.
Result<void> measure_site(const SiteMeasuring& measuring, SiteLocalizer& localizer,
                          std::size_t scan_index, SiteRows& rows);

}  // namespace sightline
