#pragma once

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/foreign/recording/recording.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// The pose whose quaternion has the same four numbers read as w x y z instead of x y z w.
Pose read_w_first(const Pose& pose);

// Poses of `drive` (those of `recording`) are read as w x y z where the scans contradict them as x
// y z w and not so, with a warning that says it: where that lays scans on each other far better, or
// turns a vehicle on its feet whose ground was above it. Of a file of quaternions with a pose for
// every scan; up to twelve scans are read. Errors: those of read_recorded_scan.
Result<void> try_w_first(PassContext& ctx, const Recording& recording, Drive& drive);

}  // namespace sightline
