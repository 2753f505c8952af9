#pragma once

#include <vector>

#include "formats/drive/drive.h"
#include "formats/foreign/recording/recording.h"
#include "passes/pass/pass.h"

namespace sightline {

struct IngestOptions {
  double tile_m = 64.0;  // the map frame's origin is a multiple of it
};
std::vector<OptionField> option_fields(IngestOptions& options);

// Which recording, and how it was made: the keys of a drive in the configuration.
std::vector<OptionField> option_fields(RecordingOptions& options);

// A drive with the counts of each scan of a recording, which is read once; its store reads the
// files again on demand. Memory holds one scan per thread. Its map frame begins at the multiple of
// tile_m at or below the first pose; at zero without poses. Up to kMostOddScans without returns and
// as many that contradict their neighbours (odd_scans) are left out, with warnings. Warns of points
// dropped (not finite, at zero, withheld), text files that may be cut, scans mostly beyond 2 km,
// senseless point times, gaps in time (longer than 1 s and three usual steps), and by
// open_recording, check_sensor and try_w_first. Errors: drive-too-short (no scans),
// time-runs-backwards, unsupported-format (so most scans: no coordinates of the sensor in metres),
// unlike-profile, mismatched-inputs (more scans contradict their neighbours), those of check_frame,
// check_pose_clock and check_upright, and those of read_recorded_scan for the first scan that
// cannot be read.
Result<Drive> ingest(PassContext& ctx, const IngestOptions& options, const Recording& opened);
// Connects a decoded drive to the files of its recording, from which its scans are read: the
// encoded drive contains no points.
void reattach(Drive& drive, const Recording& recording);
inline constexpr Pass kIngest = Pass{"ingest", 6, "drive", "Recorded drives", &ingest}
                                    .in(Stage::kDrives)
                                    .with({.scan_s = 0.0007, .million_points_s = 0.03});

}  // namespace sightline
