#pragma once

#include <vector>

#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass.h"

namespace sightline {

enum class AlignMode { kAuto, kGiven, kAlign };

struct AlignDriveOptions {
  // auto: given poses are in the map's world and kept, and scans are compared with the map there;
  // estimated and refined ones are aligned.
  // given: nothing is aligned. align: everything is.
  AlignMode mode = AlignMode::kAuto;
  double candidate_step_m = 2.0;  // between places of the route where scans are searched for
  bool may_be_elsewhere = false;  // one of several drives: it need not be in the map
  bool subtracts_offset = false;  // a constant one of given poses from the map's
};
std::vector<OptionField> option_fields(AlignDriveOptions& options);

// The trajectory of another drive of the place, in the map's frame. `own`: its poses in a frame of
// its own, or nearly in the map's. Each piece of it is placed by itself; one that is not found, or
// a whole drive that may be elsewhere, is moved 2 km from every site, with a warning. A warning,
// too, for a drive that measures larger or smaller than the map, and for given poses that differ
// from the map's by a constant. Errors: mismatched-inputs (`own` is not of the drive), empty-map,
// no-overlap (no placement of any piece is confirmed, or the scans do not show this map),
// trajectory-lost (no solution), and those of reading a scan.
Result<Trajectory> align_drive(PassContext& ctx, const AlignDriveOptions& options,
                               const Drive& drive, const Trajectory& own, const TiledNds& nds,
                               const Sites& sites);
inline constexpr Pass kAlignDrive =
    Pass{"align-drive", 7, "aligned", "Aligning a second drive with the map", &align_drive}.in(
        Stage::kTiles);

}  // namespace sightline
