#pragma once

#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"

namespace sightline {

// Forecasts of an odometry's ways once more ("Forecasts of the way" in schemas/definitions.md, v1),
// with what was measured behind them too: ways by wheels with the scale of the whole drive, ways by
// accelerations with the speeds that scans measure before and behind. Poses behind move along.
// Steps keep their rotations and what scans constrain of them; their way_share becomes that of the
// smoothed ways. Warns where wheels contradict the scans, and where their clock is another one. The
// odometry as it is where the drive has no such sensors.
void smooth_forecasts(const PassContext& ctx, const Drive& drive, Odometry& odometry);

}  // namespace sightline
