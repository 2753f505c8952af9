#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

// Whether drives agree on how far away things are; part of estimate-trajectory.

namespace sightline {

// Two parts of a drive that do not.
struct ScaleDifference {
  std::uint32_t earlier = 0;
  std::uint32_t later = 0;
  double ratio = 1.0;  // of what the later one measures to what the earlier one does
  std::uint32_t scan_count = 0;
};

// Scans of a part that the trajectory lays beside an earlier part, four of each pair, evenly along
// the way, are matched to what the earlier one saw there at scales of 0.96 to 1.04; each part with
// the three earlier ones that it meets most. Told are pairs whose median of three scans or more is
// over 0.3 % off 1, where three quarters of the scans are off that way by half as much. Scans of
// recorded streets and of generated towns are off by 0.2 % at most, their medians by 0.1 %. A drive
// whose sensor measures otherwise is joined all the same and puts its walls beside those of the
// others; its loops, met in the middle, do not say so. `from`: scans before it are not judged, but
// others are by them. Shared by ctx.threads. Error: what reading a scan says.
Result<std::vector<ScaleDifference>> find_scale_differences(const PassContext& ctx,
                                                            const Drive& drive,
                                                            const Trajectory& trajectory,
                                                            std::size_t from = 0);

std::string to_text(const ScaleDifference& found, const Drive& drive);
// One warning of all of them; none where there are none.
void warn_of_scale_differences(const PassContext& ctx, const Drive& drive,
                               const std::vector<ScaleDifference>& found);

}  // namespace sightline
