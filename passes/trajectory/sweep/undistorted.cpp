#include "passes/trajectory/sweep/undistorted.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "formats/geometry.h"
#include "passes/trajectory/sweep/turn_curve.h"

namespace sightline {
namespace {

// Steps of 1.2 s or five metres still bend little.
constexpr std::int64_t kLongestGap_ns = 1'500'000'000;
// A step this much longer than its neighbours crosses a gap of the recording, whatever its stamps
// are; shorter ones occur when vehicles start.
constexpr double kOutOfStep = 3.0;
constexpr double kLeastLeap_m = 1.0;
// The range of an offset of 32 bits.
constexpr std::int64_t kFarthestPoint_ns = std::int64_t{1} << 31;

// Even motion from one pose to the next: linear in position, about one axis in rotation.
struct Segment {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;
  Pose T_map_from = Pose::Identity();
  Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
  AxisAngle turn{};
  Eigen::Matrix3d R_map_to = Eigen::Matrix3d::Identity();

  // R_map_to follows from the rest.
  void put(ByteWriter& writer) const {
    writer.put(from_ns);
    writer.put(to_ns);
    encode(T_map_from, writer);
    for (int axis = 0; axis < 3; ++axis) writer.put(step_m[axis]);
    for (int axis = 0; axis < 3; ++axis) writer.put(turn.axis[axis]);
    writer.put(turn.angle_rad);
  }

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
  segment.R_map_to = to.T_map_vehicle.linear();
  return segment;
}

void put(std::span<const TurnRate> rates, ByteWriter& writer) {
  for (const TurnRate& rate : rates) encode(rate, writer);
}

// Whether a segment is much longer than those on both sides.
bool is_leap(const std::vector<Segment>& segments, std::size_t i) {
  const double length_m = segments[i].step_m.norm();
  if (segments.size() < 2 || length_m <= kLeastLeap_m) return false;
  const double before_m = i > 0 ? segments[i - 1].step_m.norm() : 0.0;
  const double after_m = i + 1 < segments.size() ? segments[i + 1].step_m.norm() : 0.0;
  return length_m > kOutOfStep * std::max(before_m, after_m);
}

// Where the vehicle was at any time of a drive.
class Motion {
 public:
  explicit Motion(const Trajectory& trajectory) {
    std::vector<Segment> all;
    const TrajectoryPose* before = nullptr;
    for (const TrajectoryPose& pose : trajectory.poses) {
      if (before && pose.stamp_ns == before->stamp_ns) continue;  // of another sensor
      const bool is_gap = before && (pose.piece != before->piece ||
                                     pose.stamp_ns - before->stamp_ns > kLongestGap_ns);
      if (before && !is_gap) all.push_back(segment_between(*before, pose));
      before = &pose;
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!is_leap(all, i)) segments_.push_back(all[i]);
    }
  }

  // The segment of the motion at a time near `stamp_ns`: the one that contains it, else the nearest
  // one that begins or ends at the stamp. nullptr: the motion is not known.
  [[nodiscard]] const Segment* segment_at(std::int64_t time_ns, std::int64_t stamp_ns) const {
    const auto behind = std::ranges::upper_bound(segments_, time_ns, {}, &Segment::from_ns);
    const Segment* before = behind == segments_.begin() ? nullptr : &*std::prev(behind);
    if (before && time_ns <= before->to_ns) return before;
    const Segment* after = behind == segments_.end() ? nullptr : &*behind;
    // At a gap or an end, the motion on the side of the stamp is extended.
    if (before && before->to_ns >= stamp_ns) return before;
    if (after && after->from_ns <= stamp_ns) return after;
    return nullptr;
  }

  // All segments that segment_at() may return for points of a scan, whose times are within
  // kFarthestPoint_ns of the stamp.
  void put_around(std::int64_t stamp_ns, std::span<const TurnRate> rates,
                  ByteWriter& writer) const {
    const auto behind = [&](std::int64_t time_ns) {
      return std::ranges::upper_bound(segments_, time_ns, {}, &Segment::from_ns);
    };
    auto first = behind(stamp_ns - kFarthestPoint_ns);
    if (first != segments_.begin()) --first;
    auto last = behind(stamp_ns + kFarthestPoint_ns);
    if (last != segments_.end()) ++last;
    for (auto segment = first; segment != last; ++segment) {
      segment->put(writer);
      if (rates.empty()) continue;
      const std::span<const TurnRate> around =
          rates_around(rates, segment->from_ns, segment->to_ns);
      writer.put<std::uint64_t>(around.size());
      put(around, writer);
    }
  }

 private:
  std::vector<Segment> segments_;  // in order of time; none across a gap or between pieces
};

// Where the vehicle was during one scan, with its turning between two poses by turn rates. Keeps
// references to both; curves are made on first use.
class MotionOfScan {
 public:
  MotionOfScan(const Motion& motion, std::span<const TurnRate> rates)
      : motion_(motion), rates_(rates) {}

  // T_map_vehicle at a time of a scan; none where the motion is not known.
  std::optional<Pose> at(std::int64_t time_ns, std::int64_t stamp_ns) {
    const Segment* segment = motion_.segment_at(time_ns, stamp_ns);
    if (!segment) return std::nullopt;
    Pose T_map_vehicle = segment->at(time_ns);
    const bool is_between = segment->from_ns <= time_ns && time_ns <= segment->to_ns;
    if (rates_.empty() || !is_between) return T_map_vehicle;
    const std::optional<TurnCurve>& curve = curve_of(*segment);
    if (curve) T_map_vehicle.linear() = curve->at(time_ns);
    return T_map_vehicle;
  }

 private:
  const std::optional<TurnCurve>& curve_of(const Segment& segment) {
    const auto [entry, is_new] = curves_.try_emplace(segment.from_ns);
    if (is_new) {
      entry->second = TurnCurve::between(
          rates_, {segment.from_ns, segment.to_ns, segment.T_map_from.linear(), segment.R_map_to});
    }
    return entry->second;
  }

  const Motion& motion_;
  std::span<const TurnRate> rates_;
  std::map<std::int64_t, std::optional<TurnCurve>> curves_;  // by the beginning of the segment
};

// Moves each point by T_lidar_then(time): the pose of the sensor at the point's time, from that at
// the stamp.
template <class PoseAt>
void move_points(Scan& scan, PoseAt&& T_lidar_then) {
  Pose T_move = Pose::Identity();
  std::optional<std::int32_t> offset_ns;  // that T_move belongs to
  for (std::size_t i = 0; i < scan.points_m.size(); ++i) {
    if (offset_ns != scan.time_offset_ns[i]) {
      offset_ns = scan.time_offset_ns[i];
      T_move = T_lidar_then(scan.stamp_ns + *offset_ns);
    }
    scan.points_m[i] = T_move * scan.points_m[i];
  }
}

// Poses at the times of a scan, linear between times 0.2 ms apart, of which the stamp is one.
// Neighbours in a scan are measured within that time, and a vehicle that turns by 1 rad/s moves
// points at 100 m by less than a micrometre off the arc.
template <class PoseAt>
class PosesBetween {
 public:
  PosesBetween(std::int64_t stamp_ns, const PoseAt& pose_at)
      : stamp_ns_(stamp_ns), pose_at_(pose_at) {}

  Pose operator()(std::int64_t time_ns) {
    const std::int64_t off_ns = time_ns - stamp_ns_;
    const std::int64_t number = off_ns / kStep_ns - (off_ns % kStep_ns < 0 ? 1 : 0);
    if (number != number_) {
      number_ = number;
      from_ = at(number);
      change_ = at(number + 1) - from_;
    }
    const double share =
        static_cast<double>(off_ns - number * kStep_ns) / static_cast<double>(kStep_ns);
    Pose between;
    between.matrix() = from_ + share * change_;
    return between;
  }

 private:
  static constexpr std::int64_t kStep_ns = 200'000;

  const Eigen::Matrix4d& at(std::int64_t number) {
    const auto [entry, is_new] = known_.try_emplace(number);
    if (is_new) entry->second = pose_at_(stamp_ns_ + number * kStep_ns).matrix();
    return entry->second;
  }

  std::int64_t stamp_ns_;
  const PoseAt& pose_at_;
  // Each ring of a scan that is stored ring after ring has the same times.
  std::unordered_map<std::int64_t, Eigen::Matrix4d> known_;
  std::optional<std::int64_t> number_;
  Eigen::Matrix4d from_ = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d change_ = Eigen::Matrix4d::Zero();
};

class UndistortedScanStore : public ScanStore {
 public:
  UndistortedScanStore(const Drive& drive, const Trajectory& trajectory)
      : drive_(drive),
        trajectory_(trajectory),
        motion_(drive.turn_rates.empty() ? trajectory : poses_of_first_sensor(drive, trajectory)) {}

  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = drive_.store->read(index);
    if (!scan || scan->time_offset_ns.empty()) return scan;
    SIGHTLINE_CHECK(scan->time_offset_ns.size() == scan->points_m.size());
    const Pose& T_vehicle_lidar = drive_.sensor_of(drive_.scans[index]).T_vehicle_lidar;
    const Pose T_map_lidar = trajectory_.poses[index].T_map_vehicle * T_vehicle_lidar;
    const Pose T_lidar_map = T_map_lidar.inverse();
    MotionOfScan motion(motion_, drive_.turn_rates);
    const auto T_lidar_then = [&](std::int64_t time_ns) -> Pose {
      const std::optional<Pose> T_map_then = motion.at(time_ns, scan->stamp_ns);
      return T_map_then ? T_lidar_map * *T_map_then * T_vehicle_lidar : Pose::Identity();
    };
    move_points(*scan, PosesBetween(scan->stamp_ns, T_lidar_then));
    scan->time_offset_ns.clear();
    return scan;
  }

  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    const std::optional<Digest> as_measured = drive_.store->identity(index);
    if (!as_measured) return std::nullopt;
    ByteWriter writer;
    writer.put(drive_.scans[index].stamp_ns);
    encode(drive_.sensor_of(drive_.scans[index]).T_vehicle_lidar, writer);
    encode(trajectory_.poses[index].T_map_vehicle, writer);
    motion_.put_around(drive_.scans[index].stamp_ns, drive_.turn_rates, writer);
    return derived_digest("undistorted", *as_measured, writer.bytes());
  }

  // Whether the motion at a scan is known.
  [[nodiscard]] bool has_motion(std::size_t index) const {
    const std::int64_t stamp_ns = drive_.scans[index].stamp_ns;
    return motion_.segment_at(stamp_ns + 1, stamp_ns) != nullptr;
  }

 private:
  Drive drive_;
  Trajectory trajectory_;
  Motion motion_;
};

class UnturnedScanStore : public ScanStore {
 public:
  explicit UnturnedScanStore(const Drive& drive) : drive_(drive) {}

  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = drive_.store->read(index);
    if (!scan || scan->time_offset_ns.empty()) return scan;
    const auto [least_ns, most_ns] = std::ranges::minmax(scan->time_offset_ns);
    const std::int64_t from_ns = scan->stamp_ns + std::min(least_ns, 0);
    const std::int64_t to_ns = scan->stamp_ns + std::max(most_ns, 0);
    const std::optional<TurnCurve> curve = TurnCurve::by_rates(drive_.turn_rates, from_ns, to_ns);
    if (!curve) return scan;
    const Pose& T_vehicle_lidar = drive_.sensor_of(drive_.scans[index]).T_vehicle_lidar;
    const Pose T_lidar_vehicle = T_vehicle_lidar.inverse();
    const Eigen::Matrix3d R_stamp_from = curve->at(scan->stamp_ns).transpose();
    move_points(*scan, [&](std::int64_t time_ns) -> Pose {
      Pose turn = Pose::Identity();
      turn.linear() = R_stamp_from * curve->at(time_ns);
      return T_lidar_vehicle * turn * T_vehicle_lidar;
    });
    return scan;
  }

  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    const std::optional<Digest> as_measured = drive_.store->identity(index);
    if (!as_measured) return std::nullopt;
    const std::int64_t stamp_ns = drive_.scans[index].stamp_ns;
    ByteWriter writer;
    writer.put(stamp_ns);
    encode(drive_.sensor_of(drive_.scans[index]).T_vehicle_lidar, writer);
    put(rates_around(drive_.turn_rates, stamp_ns - kFarthestPoint_ns, stamp_ns + kFarthestPoint_ns),
        writer);
    return derived_digest("without turning", *as_measured, writer.bytes());
  }

 private:
  Drive drive_;
};

}  // namespace

Drive undistorted(const Drive& drive, const Trajectory& trajectory) {
  Drive straight =
      with_store(drive, std::make_shared<const UndistortedScanStore>(drive, trajectory));
  for (ScanInfo& scan : straight.scans) scan.has_point_times = false;
  straight.turn_rates.clear();
  return straight;
}

Trajectory poses_of_first_sensor(const Drive& drive, const Trajectory& trajectory) {
  Trajectory of_first = trajectory;
  of_first.poses.clear();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (drive.scans[i].sensor_index == 0) of_first.poses.push_back(trajectory.poses[i]);
  }
  return of_first;
}

std::size_t scans_without_motion(const Drive& drive, const Trajectory& trajectory) {
  const UndistortedScanStore store(drive, trajectory);
  std::size_t still = 0;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (drive.scans[i].has_point_times && !store.has_motion(i)) ++still;
  }
  return still;
}

Drive without_turning(const Drive& drive) {
  return with_store(drive, std::make_shared<const UnturnedScanStore>(drive));
}

}  // namespace sightline
