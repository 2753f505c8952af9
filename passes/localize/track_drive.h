#pragma once

#include <vector>

#include "formats/annotation/drive_tracks.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/localize/measure_error.h"
#include "passes/pass/pass.h"

namespace sightline {

struct TrackDriveOptions {
  double lost_beyond_m = 1.0;    // an error above this ends a track
  double reach_m = 10.0;         // a site farther away than this says nothing; the map's own
  MeasureErrorOptions matching;  // how a scan is matched, and against what it is judged
};
std::vector<OptionField> option_fields(TrackDriveOptions& options);

// Replays a drive through a map as a vehicle localizes ("Continuous localization" in
// schemas/definitions.md): at the map's range and look for each limit, by its plan, and at each of
// its looks and ranges throughout.
// Errors: mismatched-inputs (trajectory and drive, or map, sites and ranges, do not belong
// together), empty-map, no-overlap (no scan within reach of a site), and what reading a scan says.
Result<DriveTracks> track_drive(PassContext& ctx, const TrackDriveOptions& options,
                                const Drive& drive, const Trajectory& trajectory,
                                const TiledNds& nds, const Sites& sites,
                                const ByFamily<RangeTable>& ranges);
inline constexpr Pass kTrackDrive =
    Pass{"track-drive", 8, "tracks", "Replaying a drive with continuous localization", &track_drive}
        .in(Stage::kSites)
        .with({.scan_s = 0.03, .million_points_s = 0.3});

}  // namespace sightline
