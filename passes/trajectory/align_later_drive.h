#pragma once

#include "passes/trajectory/align_drive.h"

namespace sightline {

// As align_drive(), for one of several drives: one that is found nowhere in the map is laid aside
// as a whole, 2 km from every site, with a warning that names it. Errors: the others of
// align_drive().
Result<Trajectory> align_later_drive(PassContext& ctx, const AlignDriveOptions& options,
                                     const Drive& drive, const Trajectory& own, const TiledNds& nds,
                                     const Sites& sites);
inline constexpr Pass kAlignLaterDrive = variant_of(kAlignDrive, &align_later_drive);

}  // namespace sightline
