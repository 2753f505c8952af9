#pragma once

#include "formats/drive/drive.h"
#include "passes/pass/pass.h"

namespace sightline {

// One drive of several through the same place by the same vehicle ("Several drives" in
// schemas/definitions.md): the scans of each of `later`, drives of one part, follow those before
// them, as a part of their own. Name, sensor and frame are those of `first`, the frame that of the
// first which has poses. Even scans stay even. Turn rates are kept with their parts. A part whose
// times begin before the last one ended, or less than kPauseBetweenParts_ns behind it, is moved in
// time as a whole, with a warning where its times were those of a clock. A drive with another
// sensor, or with the same one elsewhere on the vehicle, is left out with a warning.
Result<Drive> join_drives(PassContext& ctx, const NoOptions& options, const Drive& first,
                          Many<Drive> later);
inline constexpr Pass kJoinDrives =
    Pass{"join-drives", 1, "drives", "Joining drives", &join_drives}.in(Stage::kGraph);

// One drive of all sensors on a vehicle: the scans of `others`, drives of one sensor each, among
// those of `drive` in order of time, distinguished by sensor_index. Name, frame and poses are those
// of `drive`, and turn rates those of the first that has some. recording_index becomes 2 x place +
// (its own modulo 2), so that it ascends and even scans stay even.
//
// Scans of others before the first and behind the last scan of drive's first sensor, and within a
// gap of more than 1 s between two of these, have no place on its trajectory: they are left out,
// and a warning counts them. Error: mismatched-inputs where that leaves none (two clocks, or two
// drives).
Result<Drive> join_sensors(PassContext& ctx, const NoOptions& options, const Drive& drive,
                           Many<Drive> others);
inline constexpr Pass kJoinSensors =
    Pass{"join-sensors", 1, "joined-drive", "Joining the scans of several sensors", &join_sensors}
        .in(Stage::kGraph);

}  // namespace sightline
