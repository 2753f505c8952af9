#include "compiler/init/pose_overlap.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "formats/foreign/recording/open_recording.h"
#include "formats/grid/cell_index.h"

namespace sightline {
namespace {

constexpr double kVoxel_m = 0.5;
constexpr std::array<double, 4> kYaws_deg = {0.0, 90.0, 180.0, -90.0};

struct Pair {
  std::size_t first = 0;
  std::size_t second = 0;
};

Eigen::Vector3d position_m(const Recording& recording, std::size_t scan) {
  return recording.scans[scan].T_world_vehicle->translation();
}

// Scans near 2 m apart, so that much of what one sees the other sees too.
std::vector<Pair> choose_pairs(const Recording& recording) {
  constexpr std::size_t kPairs = 6;
  constexpr double kLeast_m = 2.0;
  constexpr double kMost_m = 10.0;
  std::vector<Pair> pairs;
  const std::size_t count = recording.scans.size();
  for (std::size_t k = 0; k < kPairs; ++k) {
    const std::size_t first = k * count / kPairs;
    for (std::size_t second = first + 1; second < count; ++second) {
      const double apart_m = (position_m(recording, second) - position_m(recording, first)).norm();
      if (apart_m < kLeast_m) continue;
      if (apart_m <= kMost_m) pairs.push_back({first, second});
      break;
    }
  }
  return pairs;
}

std::vector<Eigen::Vector3d> upright_points(const PointCloudFile& cloud, double height_m) {
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

struct Clouds {
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
  Pose T_first_second;  // of the frame that the poses are of
};

double share_that_falls_on(const Clouds& clouds, double yaw_deg) {
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.rotate(
      Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()));
  const Pose T = T_vehicle_lidar.inverse() * clouds.T_first_second * T_vehicle_lidar;
  CellIndex taken;
  for (const Eigen::Vector3d& point_m : clouds.first) taken.add(cell_key(point_m, kVoxel_m));
  std::size_t on = 0;
  for (const Eigen::Vector3d& point_m : clouds.second) {
    on += taken.find(cell_key(T * point_m, kVoxel_m)) != CellIndex::kNone ? 1 : 0;
  }
  return clouds.second.empty()
             ? 0.0
             : static_cast<double>(on) / static_cast<double>(clouds.second.size());
}

Result<std::vector<Clouds>> read_pairs(const Recording& recording, double height_m) {
  std::vector<Clouds> read;
  for (const Pair& pair : choose_pairs(recording)) {
    SIGHTLINE_ASSIGN(const PointCloudFile first, read_listed_scan(recording, pair.first));
    SIGHTLINE_ASSIGN(const PointCloudFile second, read_listed_scan(recording, pair.second));
    read.push_back({upright_points(first, height_m), upright_points(second, height_m),
                    recording.scans[pair.first].T_world_vehicle->inverse() *
                        *recording.scans[pair.second].T_world_vehicle});
  }
  return read;
}

void describe_way(const Recording& recording, PoseOverlap& overlap) {
  double climbed_m = 0.0;
  std::size_t upright = 0;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    // Within 45 degrees.
    upright += recording.scans[i].T_world_vehicle->linear()(2, 2) > 0.7 ? 1 : 0;
    if (i == 0) continue;
    const Eigen::Vector3d step_m = position_m(recording, i) - position_m(recording, i - 1);
    overlap.length_m += step_m.norm();
    climbed_m += std::abs(step_m.z());
  }
  overlap.is_z_up = 2 * upright > recording.scans.size() && 2.0 * climbed_m < overlap.length_m;
}

}  // namespace

Result<PoseOverlap> measure_overlap(const Recording& recording, double height_m) {
  // Another yaw of the sensor is a strong claim.
  constexpr double kFarBetter = 1.5;
  PoseOverlap overlap;
  for (const RecordedScan& scan : recording.scans) {
    if (!scan.T_world_vehicle) return overlap;
  }
  describe_way(recording, overlap);
  SIGHTLINE_ASSIGN(const std::vector<Clouds> pairs, read_pairs(recording, height_m));
  overlap.pairs = pairs.size();
  if (pairs.empty()) return overlap;
  for (const double yaw_deg : kYaws_deg) {
    double sum = 0.0;
    for (const Clouds& clouds : pairs) sum += share_that_falls_on(clouds, yaw_deg);
    const double share = sum / static_cast<double>(pairs.size());
    if (yaw_deg != 0.0 && share < kFarBetter * overlap.share) continue;
    overlap.share = share;
    overlap.yaw_deg = yaw_deg;
  }
  return overlap;
}

}  // namespace sightline
