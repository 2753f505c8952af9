#pragma once

#include <cstdint>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass.h"

namespace sightline {

// Which scans of drives beside an earlier map are laid into the new one.
enum class LaidScans : std::uint8_t { kOfChanges, kAll };

struct ChooseScansOptions {
  LaidScans laid = LaidScans::kOfChanges;
  int known_drives = 3;          // so many drives of the earlier map know a place
  double reach_m = 60.0;         // scans this near a change are laid
  double voxel_m = 0.2;          // edge of the voxels that are compared
  double least_change_m2 = 1.5;  // of what went or came, within 4 m
};
std::vector<OptionField> option_fields(ChooseScansOptions& options);

// The trajectory with `is_laid` of each scan. Scans that were released stay as they were released.
// A scan of another drive is not laid where `known_drives` drives of the earlier map, laid, passed
// the same way, and where nothing within reach has changed since (schemas/definitions.md, "Several
// drives"). Errors: mismatched-inputs (the trajectory or the undistorted scans are not of this
// drive), and those of reading a scan.
Result<Trajectory> choose_scans(PassContext& ctx, const ChooseScansOptions& options,
                                const Drive& drive, const Drive& undistorted,
                                const Trajectory& trajectory, const ReleasedPoses& released);
inline constexpr Pass kChooseScans =
    Pass{"choose-scans", 2, "laid-scans", "Scans that show changes of an earlier map",
         &choose_scans}
        .in(Stage::kTiles);

}  // namespace sightline
