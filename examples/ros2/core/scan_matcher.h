#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "map_matcher.h"
#include "pose_buffer.h"
#include "poses.h"
#include "report.h"

// The node that takes the place of Autoware's ndt_scan_matcher, without ROS: what each message and
// each call does. A replay of a recording drives it as the node does.

namespace sightline_ros2 {

// What decides whether a pose is published.
enum class ConvergedBy : std::int64_t {
  kTransformProbability = 0,
  kNearestVoxelLikelihood = 1,
  kIntegrity = 2  // the localizer's own test of matches in succession
};
// Which pose is published with which covariance.
enum class CovarianceOf : std::int64_t {
  kFixedValue = 0,  // of the scan alone, with output_pose_covariance, of the vehicle's axes
  kScan = 1,        // of the scan alone: for a filter, which supplied the start
  kPose = 4         // the most probable one, given the start: for a vehicle without a filter
};

// By the names of Autoware's parameters, which README.md lists.
struct ScanMatcherOptions {
  std::string map_frame = "map";
  double timeout_s = 1.0;
  double required_distance_m = 10.0;
  std::int64_t particles_num = 504;
  double initial_pose_timeout_s = 1.0;
  double initial_pose_distance_tolerance_m = 10.0;
  double initial_to_result_distance_tolerance_m = 3.0;
  double critical_upper_bound_exe_time_ms = 100.0;
  std::int64_t skipping_publish_num = 5;
  ConvergedBy converged_by = ConvergedBy::kIntegrity;
  double least_transform_probability = 3.0;
  double least_nearest_voxel_likelihood = 2.3;
  bool has_no_ground_score = false;
  double z_margin_m = 0.8;
  CovarianceOf covariance_of = CovarianceOf::kScan;
  Covariance output_pose_covariance{};
  double covariance_factor = 1.0;
  bool has_protection = true;  // levels of the pose that the filter then has: a second match
};

struct IncomingScan {
  std::int64_t stamp_ns = 0;
  ScanPoints scan;
  std::shared_ptr<const void> memory;  // of the points, kept until the next scan
  std::string transform_fault;         // why T_base_points is not known; empty: it is
};

struct NoGroundScore {
  double transform_probability = 0.0;
  double nearest_voxel_likelihood = 0.0;
  std::vector<double> points_base_m;  // x y z each
};

struct ScanResult {
  Report report;
  bool is_converged = false;  // the pose is published
  bool is_matched = false;    // what follows is set
  MapMatch match;
  std::optional<MapMatch> fused;  // the most probable pose, given the start
  Covariance covariance{};        // that is published
  PoseAtTime initial;
  double exe_time_ms = 0.0;
  double transform_probability = 0.0;
  Pose initial_to_result;
  double distance_m = 0.0;
  double distance_old_m = 0.0;
  double distance_new_m = 0.0;
  std::optional<NoGroundScore> no_ground;
};

struct AlignResult {
  Report report;
  bool is_success = false;
  bool is_reliable = false;  // as likely as right places are, and no other place nearly as likely
  StampedPose pose;
  std::vector<Pose> tried;
};

// One thread at a time.
class ScanMatcher {
 public:
  ScanMatcher(MapMatcher matcher, const ScanMatcherOptions& options);

  Report trigger(bool activates, std::int64_t now_ns);
  Report add_initial_pose(const StampedPose& pose, const std::string& frame_id);
  ScanResult take(const IncomingScan& scan, std::int64_t now_ns);
  // From a pose in the map's frame; none where its frame could not be transformed, for the reason
  // given.
  AlignResult align(const std::optional<StampedPose>& start, const std::string& transform_fault,
                    std::int64_t now_ns);
  [[nodiscard]] Report map_status(std::int64_t now_ns) const;

  [[nodiscard]] const MapMatcher& map() const { return matcher_; }

 private:
  bool check_points(const IncomingScan& scan, std::int64_t now_ns, Report& report);
  bool find_start(const IncomingScan& scan, ScanResult& result);
  bool match(const IncomingScan& scan, ScanResult& result);
  void score_start(const IncomingScan& scan, ScanResult& result);
  bool is_good_score(ScanResult& result);
  void report_match(ScanResult& result);
  void report_protection(ScanResult& result);
  void score_no_ground(const IncomingScan& scan, ScanResult& result);
  [[nodiscard]] Covariance published_covariance(const MapMatch& match) const;

  MapMatcher matcher_;
  ScanMatcherOptions options_;
  PoseBuffer initial_poses_;
  bool is_activated_ = false;
  std::optional<IncomingScan> last_scan_;
  std::optional<std::int64_t> tracked_ns_;  // of the last scan whose pose was published
  sightline_monitor monitor_{};
  std::int64_t skipped_count_ = 0;
};

}  // namespace sightline_ros2
