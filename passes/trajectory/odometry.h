#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/local_map.h"

// The parts of estimate-trajectory that match scans. Poses here are the sensor's: T_map_lidar.

namespace sightline {

// A scan within its sensor's range, thinned, in the frame of the drive's first sensor.
struct ThinnedScan {
  std::vector<Eigen::Vector3d> to_match_m;
  std::vector<Eigen::Vector3d> to_map_m;  // denser: what local maps are made of
};
// Errors: what reading a scan says.
Result<ThinnedScan> read_thinned(const Drive& drive, std::size_t index);

struct LocalMatch {
  Pose T_map_lidar = Pose::Identity();
  double likelihood = 0.0;    // mean over points of the largest single term of the fine score
  double scored_share = 0.0;  // of the points that have an ND near
  // By likelihood alone, once enough points speak: the share draws scans onto each other, ring on
  // ring, whether the vehicle moved or not.
  [[nodiscard]] bool is_better_than(const LocalMatch& other) const;
  [[nodiscard]] bool is_good() const;
};

// Coarse, then fine, from one start.
LocalMatch match_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                         const Pose& T_map_start);

// The same from starts up to `reach_m` around in the plane; the best end.
LocalMatch search_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                          const Pose& T_map_start, double reach_m);

struct Odometry {
  std::vector<Pose> T_map_lidar;  // one a scan
  std::vector<bool> is_matched;   // false: carried on from given poses or constant velocity
  std::vector<double> driven_m;   // arc length up to each scan
};

// Scan after scan against a map of the last `local_map_m` of the way. `given`, one a scan, are
// T_map_lidar where a recording has them: they put the first scan in its place, and carry on where
// matching fails.
// Errors: trajectory-lost, drive-too-short, and what reading a scan says.
Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const std::vector<std::optional<Pose>>& given);

}  // namespace sightline
