#include "passes/trajectory/undistort_scans.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "formats/drive/trajectory_of_drive.h"
#include "formats/rotation.h"
#include "passes/trajectory/sweep/sweep_trial.h"
#include "passes/trajectory/sweep/swept_drive.h"

namespace sightline {
namespace {

constexpr std::int64_t kLongestGap_ns = 1'000'000'000;

// Even motion from one pose to the next: linear in position, about one axis in rotation.
struct Segment {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;
  Pose T_map_from = Pose::Identity();
  Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
  AxisAngle turn{};

  // Also before from_ns and behind to_ns.
  [[nodiscard]] Pose at(std::int64_t time_ns) const {
    const double fraction =
        static_cast<double>(time_ns - from_ns) / static_cast<double>(to_ns - from_ns);
    Pose T_map_vehicle = T_map_from;
    T_map_vehicle.linear() =
        T_map_from.linear() * rotation_matrix({turn.axis, fraction * turn.angle_rad});
    T_map_vehicle.translation() += fraction * step_m;
    return T_map_vehicle;
  }
};

Segment segment_between(const TrajectoryPose& from, const TrajectoryPose& to) {
  Segment segment{from.stamp_ns, to.stamp_ns, from.T_map_vehicle};
  segment.step_m = to.T_map_vehicle.translation() - from.T_map_vehicle.translation();
  segment.turn = axis_angle(from.T_map_vehicle.linear().transpose() * to.T_map_vehicle.linear());
  return segment;
}

// Where the vehicle was at any time of a drive.
class Motion {
 public:
  explicit Motion(const Trajectory& trajectory) {
    const TrajectoryPose* before = nullptr;
    for (const TrajectoryPose& pose : trajectory.poses) {
      if (before && pose.stamp_ns == before->stamp_ns) continue;  // of another sensor
      const bool is_gap = before && (pose.piece != before->piece ||
                                     pose.stamp_ns - before->stamp_ns > kLongestGap_ns);
      if (before && !is_gap) segments_.push_back(segment_between(*before, pose));
      before = &pose;
    }
  }

  // The segment that says how the vehicle moved at a time near `stamp_ns`: the one that holds it,
  // else the nearest one that begins or ends at the stamp. nullptr: nothing is known.
  [[nodiscard]] const Segment* segment_at(std::int64_t time_ns, std::int64_t stamp_ns) const {
    const auto behind = std::ranges::upper_bound(segments_, time_ns, {},
                                                 [](const Segment& s) { return s.from_ns; });
    const Segment* before = behind == segments_.begin() ? nullptr : &*std::prev(behind);
    if (before && time_ns <= before->to_ns) return before;
    const Segment* after = behind == segments_.end() ? nullptr : &*behind;
    // A gap or an end: what bounds it on the side of the stamp goes on.
    if (before && before->to_ns >= stamp_ns) return before;
    if (after && after->from_ns <= stamp_ns) return after;
    return nullptr;
  }

 private:
  std::vector<Segment> segments_;  // in order of time; none across a gap or between pieces
};

class UndistortedScanStore : public ScanStore {
 public:
  UndistortedScanStore(const Drive& drive, const Trajectory& trajectory)
      : drive_(drive), trajectory_(trajectory), motion_(trajectory) {}

  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = drive_.store->read(index);
    if (!scan || scan->time_offset_ns.empty()) return scan;
    SIGHTLINE_CHECK(scan->time_offset_ns.size() == scan->points_m.size());
    const Pose& T_vehicle_lidar = drive_.sensor_of(drive_.scans[index]).T_vehicle_lidar;
    const Pose T_map_lidar = trajectory_.poses[index].T_map_vehicle * T_vehicle_lidar;
    const Pose T_lidar_map = T_map_lidar.inverse();
    Pose T_lidar_then = Pose::Identity();
    std::optional<std::int32_t> offset_ns;  // that T_lidar_then belongs to
    for (std::size_t i = 0; i < scan->points_m.size(); ++i) {
      if (offset_ns != scan->time_offset_ns[i]) {
        offset_ns = scan->time_offset_ns[i];
        const std::int64_t time_ns = scan->stamp_ns + *offset_ns;
        const Segment* segment = motion_.segment_at(time_ns, scan->stamp_ns);
        T_lidar_then =
            segment ? T_lidar_map * segment->at(time_ns) * T_vehicle_lidar : Pose::Identity();
      }
      scan->points_m[i] = T_lidar_then * scan->points_m[i];
    }
    scan->time_offset_ns.clear();
    return scan;
  }

  // Whether anything is known of how the vehicle moved at a scan.
  [[nodiscard]] bool knows_motion(std::size_t index) const {
    const std::int64_t stamp_ns = drive_.scans[index].stamp_ns;
    return motion_.segment_at(stamp_ns + 1, stamp_ns) != nullptr;
  }

 private:
  Drive drive_;
  Trajectory trajectory_;
  Motion motion_;
};

// By times that nobody wrote down, where that makes the scans fit each other better.
Result<Drive> undistorted_by_order(PassContext& ctx, const Drive& drive,
                                   const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const Drive swept, with_sweep_times(drive));
  if (swept.store == drive.store) return drive;
  const Drive straight = undistorted(swept, trajectory);
  SIGHTLINE_ASSIGN(const bool is_sharper, is_sharper_undistorted(ctx, drive, straight, trajectory));
  return is_sharper ? straight : drive;
}

}  // namespace

Drive undistorted(const Drive& drive, const Trajectory& trajectory) {
  Drive straight =
      with_store(drive, std::make_shared<const UndistortedScanStore>(drive, trajectory));
  for (ScanInfo& scan : straight.scans) scan.has_point_times = false;
  return straight;
}

std::vector<OptionField> option_fields(UndistortScansOptions& options) {
  return {flag("enabled", options.enabled,
               "take the vehicle's motion during a scan out of it, where its points carry times")};
}

Result<Drive> undistort_scans(PassContext& ctx, const UndistortScansOptions& options,
                              const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  const auto timed =
      std::ranges::count_if(drive.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  if (timed == 0) return options.enabled ? undistorted_by_order(ctx, drive, trajectory) : drive;
  const std::string name = "drive " + drive.name + ": ";
  if (!options.enabled) {
    ctx.warn(name + std::to_string(timed) +
             " scans have point times that are not used: undistort-scans is off");
    return drive;
  }
  const UndistortedScanStore store(drive, trajectory);
  std::size_t still = 0;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (drive.scans[i].has_point_times && !store.knows_motion(i)) ++still;
  }
  if (still > 0) {
    ctx.warn(name + std::to_string(still) +
             " scans have no other pose within 1 s; they are taken to stand still");
  }
  return undistorted(drive, trajectory);
}

}  // namespace sightline
