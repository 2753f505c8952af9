#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Two parts of a drive that differ.
struct ScaleDifference {
  std::uint32_t earlier = 0;
  std::uint32_t later = 0;
  double ratio = 1.0;  // of the later one's distances to the earlier one's
  std::uint32_t scan_count = 0;
};

// Compares each part of a drive with the three earlier parts that it meets most: four scans of each
// pair, evenly along the common way, are matched to maps of the earlier part at scales of 0.96 to
// 1.04 (best_scale). Pairs whose common_ratio is not 1 are returned. Such a drive is joined all the
// same, and doubles walls; its loops, which match in the middle, do not show it. `from`: earlier
// scans are not judged, but others are compared with them. Shared by ctx.threads. Error: that of
// reading a scan.
Result<std::vector<ScaleDifference>> find_scale_differences(const PassContext& ctx,
                                                            const Drive& drive,
                                                            const Trajectory& trajectory,
                                                            std::size_t from = 0);

std::string to_text(const ScaleDifference& found, const Drive& drive);

// One warning of all differences; none without any. Error: that of finding them.
Result<void> warn_of_scale_differences(const PassContext& ctx, const Drive& drive,
                                       const Trajectory& trajectory, std::size_t from = 0);

}  // namespace sightline
