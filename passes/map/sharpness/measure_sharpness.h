#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/sharpness.h"
#include "passes/map/sharpness/point_sharpness.h"
#include "passes/pass/pass.h"

namespace sightline {

std::vector<OptionField> option_fields(MeasureSharpnessOptions& options);

// How sharp the drive's scans are when the trajectory lays them on each other, and when the poses
// that came with the drive do, where every scan taken has one ("Sharpness" in
// schemas/definitions.md, v2). Tile by tile: memory does not grow with the drive. Errors:
// mismatched-inputs (the trajectory is not of the drive) and what reading a scan says.
Result<Sharpness> measure_sharpness(PassContext& ctx, const MeasureSharpnessOptions& options,
                                    const Drive& drive, const Trajectory& trajectory);
inline constexpr Pass kMeasureSharpness =
    Pass{"measure-sharpness", 4, "sharpness", "How sharp the map is", &measure_sharpness}
        .in(Stage::kTiles)
        .with({.million_points_s = 0.05});

}  // namespace sightline
