#include "compiler/init/pose_sources.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/units.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/ros_messages.h"

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

}  // namespace sightline
