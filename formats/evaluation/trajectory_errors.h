#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/geometry.h"

// How far poses are from those of a reference, as the program evo computes it
// (github.com/MichaelGrupp/evo: evo_ape and evo_rpe, "Errors of poses" in schemas/definitions.md).

namespace sightline {

struct TimedPose {
  std::int64_t stamp_ns = 0;
  Pose T_world_vehicle = Pose::Identity();
};

enum class DeltaUnit { kFrames, kMetres };

struct TrajectoryErrorOptions {
  std::int64_t most_apart_ns = 10'000'000;  // evo: --t_max_diff
  bool is_aligned = false;                  // by one rotation and translation; evo: --align
  double delta = 1.0;                       // of relative errors; evo: --delta
  DeltaUnit unit = DeltaUnit::kFrames;      // evo: --delta_unit f or m
};

struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;
  double std = 0.0;
  double min = 0.0;
  double max = 0.0;
};
// All 0 where there are none. Sums in the order of the errors.
ErrorStatistics statistics_of(std::span<const double> errors);

struct TrajectoryErrors {
  std::size_t pair_count = 0;    // poses that have one of the reference near in time
  ErrorStatistics absolute_m;    // ape, translation_part
  ErrorStatistics absolute_deg;  // ape, angle_deg
  ErrorStatistics relative_m;    // rpe, translation_part; count 0 where no two are delta apart
  ErrorStatistics relative_deg;  // rpe, angle_deg
  Pose T_reference_world = Pose::Identity();  // by which the poses were aligned
};

// Both ascend in time. Errors: mismatched-inputs (no two poses are near in time; with is_aligned:
// fewer than three, or all on one line, so that the rotation is not known).
Result<TrajectoryErrors> trajectory_errors(std::span<const TimedPose> reference,
                                           std::span<const TimedPose> poses,
                                           const TrajectoryErrorOptions& options);

}  // namespace sightline
