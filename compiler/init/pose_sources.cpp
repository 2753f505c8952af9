#include "compiler/init/pose_sources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "formats/base/units.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/ros_messages.h"
#include "passes/ingest/pose_reading.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// T_vehicle_lidar as the configuration writes it.
void set_mounting(const Pose& T_vehicle_lidar, RecordingOptions& options) {
  const auto to_micro = [](double value) { return std::round(1e6 * value) / 1e6; };
  const Eigen::Matrix3d R = T_vehicle_lidar.linear();
  options.lidar_x_m = to_micro(T_vehicle_lidar.translation().x());
  options.lidar_y_m = to_micro(T_vehicle_lidar.translation().y());
  options.lidar_z_m = to_micro(T_vehicle_lidar.translation().z());
  options.lidar_roll_deg = to_micro(kDegPerRad * std::atan2(R(2, 1), R(2, 2)));
  options.lidar_pitch_deg = to_micro(-kDegPerRad * std::asin(std::clamp(R(2, 0), -1.0, 1.0)));
  options.lidar_yaw_deg = to_micro(kDegPerRad * std::atan2(R(1, 0), R(0, 0)));
}

// Of the bag that holds the scans.
std::vector<PoseSource> pose_topics(const fs::path& bag, const Recording& recording) {
  std::vector<PoseSource> sources;
  const Result<std::vector<BagTopic>> topics = list_bag_topics(bag);
  if (!topics) return sources;
  const Result<std::optional<Pose>> mounting = bag_mounting(bag, recording.container->frame());
  for (const BagTopic& topic : *topics) {
    const bool are_transforms = is_transforms_message(topic.type);
    if (are_transforms && topic.name.ends_with("tf_static")) continue;
    if (!are_transforms && !is_pose_message(topic.type)) continue;
    sources.push_back({bag.string(), topic.name, are_transforms, {}});
    if (are_transforms || !mounting || !*mounting) continue;
    sources.push_back(sources.back());
    sources.back().T_vehicle_lidar = *mounting;
  }
  return sources;
}

constexpr std::array<double, 4> kYaws_deg = {0.0, 90.0, 180.0, -90.0};

Eigen::Vector3d position_m(const Recording& recording, std::size_t scan) {
  return recording.scans[scan].T_world_vehicle->translation();
}

struct Clouds {
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
  Pose T_first_second;  // of the sensor by its poses and its mounting
};

double share_at_yaw(const Clouds& clouds, double yaw_deg) {
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.rotate(
      Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()));
  const Pose T = T_vehicle_lidar.inverse() * clouds.T_first_second * T_vehicle_lidar;
  return share_that_falls_on(clouds.first, clouds.second, T);
}

Result<std::vector<Clouds>> read_pairs(const Recording& recording, double height_m) {
  std::vector<Clouds> read;
  const Pose& T_vehicle_lidar = recording.sensor.T_vehicle_lidar;
  for (const ScanPair& pair : choose_pairs(recording)) {
    SIGHTLINE_ASSIGN(const PointCloudFile first, read_listed_scan(recording, pair.first));
    SIGHTLINE_ASSIGN(const PointCloudFile second, read_listed_scan(recording, pair.second));
    read.push_back(
        {upright_returns(first, height_m), upright_returns(second, height_m),
         T_vehicle_lidar.inverse() * recording.scans[pair.first].T_world_vehicle->inverse() *
             *recording.scans[pair.second].T_world_vehicle * T_vehicle_lidar});
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

std::string PoseSource::words() const {
  if (topic.empty()) return fs::path(file).filename().string();
  return topic + (T_vehicle_lidar ? " with the mounting of the bag's transforms" : "");
}

std::vector<PoseSource> pose_sources(const FoundScans& found, const Recording& listed) {
  std::vector<PoseSource> sources;
  if (is_ros_bag(found.scans)) sources = pose_topics(found.scans, listed);
  for (const fs::path& file : found.pose_files) sources.push_back({file.string(), "", false, {}});
  return sources;
}

RecordingOptions with_poses(const PoseSource& source, RecordingOptions options) {
  options.poses = source.file;
  options.poses_topic = source.topic;
  if (source.are_transforms) options.poses_of = PosesOf::kSensor;
  if (source.T_vehicle_lidar) set_mounting(*source.T_vehicle_lidar, options);
  return options;
}

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
    for (const Clouds& clouds : pairs) sum += share_at_yaw(clouds, yaw_deg);
    const double share = sum / static_cast<double>(pairs.size());
    if (yaw_deg != 0.0 && share < kFarBetter * overlap.share) continue;
    overlap.share = share;
    overlap.yaw_deg = yaw_deg;
  }
  return overlap;
}

}  // namespace sightline
