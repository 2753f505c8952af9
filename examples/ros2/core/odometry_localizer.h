#pragma once

#include <cstdint>
#include <optional>

#include "map_matcher.h"
#include "poses.h"
#include "report.h"

// A vehicle with odometry and no filter of its own, as one of Nav2, without ROS.

namespace sightline_ros2 {

struct OdometryOptions {
  double error_share = 0.05;      // of a way that odometry measures, one standard deviation
  double error_rad_per_m = 0.02;  // of its turn
  double least_error_m = 0.02;    // from one scan to the next
  double least_error_rad = 0.005;
  std::size_t start_count = 504;  // of a search around an initial pose
};

enum class TrackState { kNoPose, kTracking, kLost };

struct TrackedScan {
  Report report;
  bool has_pose = false;  // what follows is set
  MapMatch match;         // its covariance is published
  PoseRows T_map_odom{};
};

// One thread at a time.
class OdometryLocalizer {
 public:
  OdometryLocalizer(MapMatcher matcher, const OdometryOptions& options)
      : matcher_(std::move(matcher)), options_(options) {}

  // Roughly where the vehicle is: its next scan is searched for around it. Its height is the
  // map's, where the map's route is near.
  void set_initial_pose(const StampedPose& T_map_base);

  TrackedScan take(std::int64_t stamp_ns, const ScanPoints& scan, const PoseRows& T_odom_base);

  [[nodiscard]] TrackState state() const { return state_; }
  [[nodiscard]] const MapMatcher& map() const { return matcher_; }

 private:
  [[nodiscard]] StampedPose predicted(const PoseRows& T_odom_base) const;
  void follow(const ScanPoints& scan, const PoseRows& T_odom_base, TrackedScan& result);
  void search(const ScanPoints& scan, const PoseRows& T_odom_base, TrackedScan& result);
  void found(const MapMatch& match, const PoseRows& T_odom_base, TrackedScan& result);

  MapMatcher matcher_;
  OdometryOptions options_;
  TrackState state_ = TrackState::kNoPose;
  std::optional<StampedPose> initial_;  // that was given and is not yet used
  StampedPose last_;                    // the last one found
  PoseRows T_odom_last_{};
  sightline_monitor monitor_{};
  std::uint32_t lost_count_ = 0;  // of scans
};

}  // namespace sightline_ros2
