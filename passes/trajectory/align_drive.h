#pragma once

#include <string>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/tiled_nds.h"
#include "passes/pass/pass.h"

namespace sightline {

enum class AlignMode { kAuto, kGiven, kAlign };

struct AlignDriveOptions {
  // auto: given poses are in the map's world and stay; estimated and refined ones are aligned.
  // given: nothing is aligned. align: everything is.
  AlignMode mode = AlignMode::kAuto;
  double candidate_step_m = 2.0;  // places of the route from which scans are looked for
  bool may_be_elsewhere = false;  // one of several drives: it need not be in the map
};
std::vector<OptionField> option_fields(AlignDriveOptions& options);

// The trajectory of another drive of the place, told in the map's frame. `own` is what the drive
// knows of itself, in a frame of its own or nearly in the map's. A few scans are matched against
// the map from everywhere on the route, both ways round, by a few of their points and at the best
// places by all of them; the placement that most of them confirm is
// followed through the drive, scan by scan, and a pose graph joins those matches with the drive's
// own steps, so that stretches beside the map are bridged: its source is estimated. Each piece of
// `own` is placed by itself; one that is found nowhere is laid aside, 2 km from every site, with a
// warning. Another one tells of a drive that measures larger or smaller than the map
// (scale_beside_map). Errors: mismatched-inputs (`own` is not of the drive), empty-map, no-overlap
// (no placement of any piece is confirmed; a drive that may be elsewhere is then placed as a whole
// 2 km from every site, with a warning), trajectory-lost (no solution), and what reading a scan
// says.
Result<Trajectory> align_drive(PassContext& ctx, const AlignDriveOptions& options,
                               const Drive& drive, const Trajectory& own, const TiledNds& nds,
                               const Sites& sites);
inline constexpr Pass kAlignDrive{"align-drive", 6, "aligned",
                                  "A second drive in the map of the first", &align_drive};

}  // namespace sightline
