#include "passes/ingest/pose_pairs.h"

#include "formats/grid/cell_index.h"

namespace sightline {

std::vector<ScanPair> choose_pairs(const Recording& recording) {
  constexpr std::size_t kPairs = 6;
  constexpr double kLeast_m = 2.0;
  constexpr double kMost_m = 10.0;
  const auto position_m = [&](std::size_t scan) -> Eigen::Vector3d {
    return recording.scans[scan].T_world_vehicle->translation();
  };
  std::vector<ScanPair> pairs;
  const std::size_t count = recording.scans.size();
  for (std::size_t k = 0; k < kPairs; ++k) {
    const std::size_t first = k * count / kPairs;
    for (std::size_t second = first + 1; second < count; ++second) {
      const double apart_m = (position_m(second) - position_m(first)).norm();
      if (apart_m < kLeast_m) continue;
      if (apart_m <= kMost_m) pairs.push_back({first, second});
      break;
    }
  }
  return pairs;
}

std::vector<Eigen::Vector3d> upright_returns(const PointCloudFile& cloud, double height_m) {
  constexpr double kAboveGround_m = 0.5;
  constexpr double kNearest_m = 3.0;
  constexpr double kFarthest_m = 30.0;
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& point_m : cloud.points_m) {
    const double away_m = point_m.norm();
    if (away_m < kNearest_m || away_m > kFarthest_m) continue;
    if (point_m.z() > kAboveGround_m - height_m) points.push_back(point_m);
  }
  return points;
}

double share_that_falls_on(const std::vector<Eigen::Vector3d>& first,
                           const std::vector<Eigen::Vector3d>& second, const Pose& T_first_second) {
  constexpr double kVoxel_m = 0.5;
  if (second.empty()) return 0.0;
  CellIndex taken;
  for (const Eigen::Vector3d& point_m : first) taken.add(cell_key(point_m, kVoxel_m));
  std::size_t on = 0;
  for (const Eigen::Vector3d& point_m : second) {
    const CellKey key = cell_key(T_first_second * point_m, kVoxel_m);
    on += taken.find(key) != CellIndex::kNone ? 1 : 0;
  }
  return static_cast<double>(on) / static_cast<double>(second.size());
}

}  // namespace sightline
