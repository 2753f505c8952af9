#include "passes/ingest/pose_reading.h"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "formats/foreign/recording/open_recording.h"
#include "formats/grid/cell_index.h"
#include "passes/pass/notices.h"

namespace sightline {
namespace {

// What the scans say of poses in one reading.
struct Evidence {
  double upright_share = 0.0;  // of poses whose vehicle stands within 45 degrees of upright
  double overlap = 0.0;        // of upright returns, mean over pairs of scans
  double ground = 0.0;         // share of near returns that lie where ground is, as posed
};

struct ReadPair {
  ScanPair scans;
  PointCloudFile first;
  PointCloudFile second;
};

double share_on_ground(const PointCloudFile& cloud, const Pose& T_world_lidar, double height_m) {
  constexpr double kNearest_m = 3.0;
  constexpr double kFarthest_m = 20.0;
  constexpr double kThickness_m = 0.4;
  double near = 0.0;
  double on_ground = 0.0;
  for (const Eigen::Vector3d& point_m : cloud.points_m) {
    const double away_m = point_m.norm();
    if (away_m < kNearest_m || away_m > kFarthest_m) continue;
    const double above_m = T_world_lidar.linear().row(2).dot(point_m) + height_m;
    near += 1.0;
    on_ground += std::abs(above_m) < kThickness_m ? 1.0 : 0.0;
  }
  return near == 0.0 ? 0.0 : on_ground / near;
}

Evidence weigh(const std::vector<ReadPair>& pairs, const SensorProfile& sensor,
               const std::vector<Pose>& poses) {
  constexpr double kUpright = 0.7;
  Evidence found;
  const auto upright = std::ranges::count_if(
      poses, [&](const Pose& pose) { return pose.linear()(2, 2) > kUpright; });
  found.upright_share = static_cast<double>(upright) / static_cast<double>(poses.size());
  for (const ReadPair& pair : pairs) {
    const Pose T_world_first = poses[pair.scans.first] * sensor.T_vehicle_lidar;
    const Pose T_world_second = poses[pair.scans.second] * sensor.T_vehicle_lidar;
    const auto share = 1.0 / static_cast<double>(pairs.size());
    found.ground += share * share_on_ground(pair.first, T_world_first, sensor.height_m);
    found.overlap += share * share_that_falls_on(upright_returns(pair.first, sensor.height_m),
                                                 upright_returns(pair.second, sensor.height_m),
                                                 T_world_first.inverse() * T_world_second);
  }
  return found;
}

bool is_far_better(const Evidence& other, const Evidence& read) {
  constexpr double kAllUpright = 0.9;
  constexpr double kFarBetter = 1.5;
  constexpr double kLeastOverlap = 0.35;
  constexpr double kNoWorse = 0.05;
  constexpr double kGroundTurned = 0.1;
  if (other.upright_share < kAllUpright) return false;
  if (other.overlap >= kLeastOverlap && other.overlap > kFarBetter * read.overlap) return true;
  return read.upright_share < 0.5 && other.ground > read.ground + kGroundTurned &&
         other.overlap > read.overlap - kNoWorse;
}

std::string warning_of(const Drive& drive, const Evidence& read, const Evidence& other) {
  return fmt::format(
      "drive {}: the quaternions of its poses do not fit the scans as x y z w ({:.0f} % of returns "
      "from walls match other scans, {:.0f} % of the poses are upright) and are read as w x y z "
      "({:.0f} % and {:.0f} %)",
      drive.name, 100.0 * read.overlap, 100.0 * read.upright_share, 100.0 * other.overlap,
      100.0 * other.upright_share);
}

}  // namespace

Pose read_w_first(const Pose& pose) {
  const Eigen::Quaterniond read(pose.linear());
  const Eigen::Quaterniond other(read.x(), read.y(), read.z(), read.w());  // w x y z
  Pose turned = pose;
  turned.linear() = other.normalized().toRotationMatrix();
  return turned;
}

Result<void> try_w_first(PassContext& ctx, const Recording& recording, Drive& drive) {
  if (!recording.has_quaternions || !drive.has_poses()) return {};
  std::vector<Pose> read;
  std::vector<Pose> other;
  for (const ScanInfo& scan : drive.scans) {
    read.push_back(*scan.T_world_vehicle);
    other.push_back(read_w_first(read.back()));
  }
  std::vector<ReadPair> pairs;
  for (const ScanPair& pair : choose_pairs(recording)) {
    SIGHTLINE_ASSIGN(PointCloudFile first, read_recorded_scan(recording, pair.first));
    SIGHTLINE_ASSIGN(PointCloudFile second, read_recorded_scan(recording, pair.second));
    pairs.push_back({pair, std::move(first), std::move(second)});
  }
  if (pairs.empty()) return {};
  const Evidence as_read = weigh(pairs, drive.sensor, read);
  const Evidence as_other = weigh(pairs, drive.sensor, other);
  if (!is_far_better(as_other, as_read)) return {};
  for (std::size_t i = 0; i < other.size(); ++i) drive.scans[i].T_world_vehicle = other[i];
  drive.notices.push_back(warned(
      ctx,
      {.code = "quaternions-reordered", .text = warning_of(drive, as_read, as_other), .unit = ""}));
  return {};
}

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
