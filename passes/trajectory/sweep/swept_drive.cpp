#include "passes/trajectory/sweep/swept_drive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "formats/base/portable_math.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

constexpr std::int64_t kLongestSweep_ns = 100'000'000;  // 10 Hz; slower LiDARs are rare
// A vehicle that seems to move farther during one scan has stamps that were made up for one scan in
// several.
constexpr double kFarthest_m = 4.0;
constexpr std::int64_t kSweepsAStep = 10;

template <class Value>
Value median(std::vector<Value> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

std::int64_t sweep_ns(const Drive& drive, const Trajectory& trajectory) {
  std::vector<std::int64_t> steps_ns;
  std::vector<double> steps_m;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    steps_ns.push_back(drive.scans[i].stamp_ns - drive.scans[i - 1].stamp_ns);
    steps_m.push_back((trajectory.poses[i].T_map_vehicle.translation() -
                       trajectory.poses[i - 1].T_map_vehicle.translation())
                          .norm());
  }
  const std::int64_t step_ns = median(steps_ns);
  const bool is_far = step_ns <= kLongestSweep_ns && median(steps_m) > kFarthest_m;
  return is_far ? step_ns / kSweepsAStep : std::min(kLongestSweep_ns, step_ns);
}

class SweptScanStore : public ScanStore {
 public:
  // Without a turn, times are by the order of the points.
  SweptScanStore(std::shared_ptr<const ScanStore> store, std::int64_t sweep_ns,
                 std::optional<SweepTurn> turn)
      : store_(std::move(store)), sweep_ns_(sweep_ns), turn_(turn) {}

  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = store_->read(index);
    if (!scan) return scan;
    const std::vector<double> times =
        turn_ ? turn_times(scan->points_m, *turn_) : sweep_times(scan->points_m);
    for (const double time : times) {
      const double offset_ns = (time - 0.5) * static_cast<double>(sweep_ns_);
      scan->time_offset_ns.push_back(static_cast<std::int32_t>(std::floor(offset_ns)));
    }
    return scan;
  }

  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    const std::optional<Digest> without_times = store_->identity(index);
    if (!without_times) return std::nullopt;
    if (!turn_) return derived_digest("swept in order", *without_times, written(sweep_ns_).bytes());
    return derived_digest("swept by a turn", *without_times,
                          written(sweep_ns_, turn_->begin_rad, turn_->is_clockwise).bytes());
  }

 private:
  std::shared_ptr<const ScanStore> store_;
  std::int64_t sweep_ns_;
  std::optional<SweepTurn> turn_;
};

Drive swept(const Drive& drive, std::int64_t sweep_ns, const std::optional<SweepTurn>& turn) {
  Drive timed =
      with_store(drive, std::make_shared<const SweptScanStore>(drive.store, sweep_ns, turn));
  for (ScanInfo& scan : timed.scans) scan.has_point_times = true;
  return timed;
}

constexpr double kPi = std::numbers::pi;
// Beams that fire together point a few degrees apart, and each scan has gaps without a return. So
// the azimuth is followed over blocks of points: the direction of a block is that of the sum of its
// points' directions in the plane.
constexpr std::size_t kBlock = 256;  // points; a few firings of a dense sensor
constexpr std::size_t kLeastBlocks = 16;
// Share of steps in the other direction: a sweep may be slightly out of order, and there is noise
// near the axis.
constexpr double kMostBackwards = 0.05;
constexpr double kLeastTurn_rad = 300.0 * kPi / 180.0;
constexpr double kMostTurn_rad = 450.0 * kPi / 180.0;

Eigen::Vector2d direction_of(std::span<const Eigen::Vector3d> points_m) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& point_m : points_m) {
    const double length_m = point_m.head<2>().norm();
    if (length_m > 0.0) sum += point_m.head<2>() / length_m;
  }
  return sum;
}

// From the first block to each, counted through full turns.
std::vector<double> turned_rad(std::span<const Eigen::Vector3d> points_m) {
  std::vector<double> turned{0.0};
  Eigen::Vector2d before = direction_of(points_m.first(kBlock));
  for (std::size_t begin = kBlock; begin + kBlock <= points_m.size(); begin += kBlock) {
    const Eigen::Vector2d now = direction_of(points_m.subspan(begin, kBlock));
    const double step_rad =
        portable_atan2(before.x() * now.y() - before.y() * now.x(), before.dot(now));
    turned.push_back(turned.back() + step_rad);
    before = now;
  }
  return turned;
}

bool is_sweep(std::span<const double> turned) {
  const double whole_rad = turned.back();
  if (std::abs(whole_rad) < kLeastTurn_rad || std::abs(whole_rad) > kMostTurn_rad) return false;
  std::size_t backwards = 0;
  for (std::size_t i = 1; i < turned.size(); ++i) {
    backwards += (turned[i] - turned[i - 1]) * whole_rad < 0.0 ? 1 : 0;
  }
  return static_cast<double>(backwards) <= kMostBackwards * static_cast<double>(turned.size());
}

constexpr std::size_t kLeastPoints = 4096;
// Scans in order of time turn once or twice; sensors have more rings.
constexpr double kLeastRings = 8.0;
// Beginnings nearer to each other count as one.
constexpr double kOneBeginning_rad = 10.0 * kPi / 180.0;

double azimuth_rad(const Eigen::Vector3d& point_m) {
  return portable_atan2(point_m.y(), point_m.x());
}

// To within half a turn of 0.
double wrapped(double angle_rad) {
  return angle_rad - 2.0 * kPi * std::round(angle_rad / (2.0 * kPi));
}

// Enough way to measure things from several sides.
constexpr std::size_t kTrialScans = 60;
// Entropies by two sets of poses differ by a few hundredths where neither is better.
constexpr double kSharper_nat = 0.05;

// Undistorting does not change scans of a vehicle that hardly moves.
constexpr double kLeastWay_m = 5.0;

struct Stretch {
  std::size_t first = 0;
  std::size_t count = 0;
};

// Way along the poses, with no step from one piece to the next.
std::vector<double> driven_m(const Trajectory& trajectory) {
  std::vector<double> driven = {0.0};
  for (std::size_t i = 1; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& from = trajectory.poses[i - 1];
    const TrajectoryPose& to = trajectory.poses[i];
    const double step_m =
        (to.T_map_vehicle.translation() - from.T_map_vehicle.translation()).norm();
    driven.push_back(driven.back() + (from.piece == to.piece ? step_m : 0.0));
  }
  return driven;
}

// How many of the poses before each one rest on something other than the scans.
std::vector<std::size_t> unconstrained_before(const Trajectory& trajectory) {
  std::vector<std::size_t> counts = {0};
  for (const TrajectoryPose& pose : trajectory.poses) {
    counts.push_back(counts.back() + (pose.unconstrained.is_any() ? 1 : 0));
  }
  return counts;
}

// Scans on which the vehicle moves: those with the fewest unconstrained poses, of these the nearest
// to the middle. Those of the middle where it never moves.
Stretch middle_stretch(const Trajectory& trajectory) {
  const std::size_t all = trajectory.poses.size();
  const std::size_t count = std::min(kTrialScans, all);
  const Stretch middle{(all - count) / 2, count};
  if (count < 2) return middle;
  const std::vector<double> driven = driven_m(trajectory);
  const std::vector<std::size_t> unconstrained = unconstrained_before(trajectory);
  std::optional<std::size_t> least;
  Stretch best = middle;
  const auto consider = [&](std::size_t first) {
    if (driven[first + count - 1] - driven[first] < kLeastWay_m) return;
    const std::size_t found = unconstrained[first + count] - unconstrained[first];
    if (least && found >= *least) return;
    least = found;
    best.first = first;
  };
  for (std::size_t off = 0; off <= all - count; ++off) {
    if (off <= middle.first) consider(middle.first - off);
    if (middle.first + off <= all - count) consider(middle.first + off);
  }
  return best;
}

}  // namespace

bool has_point_times(const Drive& drive) {
  return std::ranges::any_of(drive.scans, &ScanInfo::has_point_times);
}

Result<std::vector<Drive>> swept_drives(const Drive& drive, const Trajectory& trajectory) {
  if (has_point_times(drive) || !drive.other_sensors.empty() || drive.scans.size() < 2) {
    return std::vector<Drive>();
  }
  SIGHTLINE_ASSIGN(const Scan first, drive.store->read(0));
  SIGHTLINE_ASSIGN(const Scan middle, drive.store->read(drive.scans.size() / 2));
  const std::int64_t duration_ns = sweep_ns(drive, trajectory);
  std::vector<Drive> drives;
  if (!sweep_times(first.points_m).empty() && !sweep_times(middle.points_m).empty()) {
    drives.push_back(swept(drive, duration_ns, std::nullopt));
  } else if (!turns_of_rings(first.points_m).empty()) {
    for (const SweepTurn& turn : turns_of_rings(middle.points_m)) {
      drives.push_back(swept(drive, duration_ns, turn));
    }
  }
  return drives;
}

std::vector<double> sweep_times(std::span<const Eigen::Vector3d> points_m) {
  if (points_m.size() < kLeastBlocks * kBlock) return {};
  const std::vector<double> turned = turned_rad(points_m);
  if (!is_sweep(turned)) return {};
  std::vector<double> times(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    // The azimuth of a block is that of its middle.
    const double at = std::clamp((static_cast<double>(i) - 0.5 * kBlock) / kBlock, 0.0,
                                 static_cast<double>(turned.size() - 1));
    const std::size_t block = std::min(static_cast<std::size_t>(at), turned.size() - 2);
    const double within = at - static_cast<double>(block);
    const double angle_rad = turned[block] + within * (turned[block + 1] - turned[block]);
    times[i] = std::clamp(angle_rad / turned.back(), 0.0, 1.0);
  }
  return times;
}

std::vector<SweepTurn> turns_of_rings(std::span<const Eigen::Vector3d> points_m) {
  if (points_m.size() < kLeastPoints) return {};
  double turned_rad = 0.0;
  std::size_t left = 0;
  std::size_t right = 0;
  double before_rad = azimuth_rad(points_m.front());
  for (const Eigen::Vector3d& point_m : points_m.subspan(1)) {
    const double now_rad = azimuth_rad(point_m);
    const double step_rad = wrapped(now_rad - before_rad);
    before_rad = now_rad;
    turned_rad += step_rad;
    left += step_rad > 0.0 ? 1 : 0;
    right += step_rad < 0.0 ? 1 : 0;
  }
  if (std::abs(turned_rad) < kLeastRings * 2.0 * kPi) return {};
  const auto most = kMostBackwards * static_cast<double>(points_m.size());
  if (static_cast<double>(std::min(left, right)) > most) return {};
  const SweepTurn as_stored{azimuth_rad(points_m.front()), turned_rad < 0.0};
  std::vector<SweepTurn> turns{{kPi, true}, {kPi, false}};
  const bool begins_behind = std::abs(wrapped(as_stored.begin_rad - kPi)) < kOneBeginning_rad;
  if (!begins_behind) turns.push_back(as_stored);
  return turns;
}

std::vector<double> turn_times(std::span<const Eigen::Vector3d> points_m, const SweepTurn& turn) {
  std::vector<double> times;
  times.reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) {
    const double left_rad = azimuth_rad(point_m) - turn.begin_rad;
    const double turns = (turn.is_clockwise ? -left_rad : left_rad) / (2.0 * kPi);
    times.push_back(turns - std::floor(turns));
  }
  return times;
}

Drive middle_of(const Drive& drive, const Trajectory& trajectory) {
  const auto [first, count] = middle_stretch(trajectory);
  return stretch_of(drive, first, count);
}

Trajectory middle_of(const Trajectory& trajectory) {
  const auto [first, count] = middle_stretch(trajectory);
  return stretch_of(trajectory, first, count);
}

double way_m(const Trajectory& trajectory) {
  return trajectory.poses.empty() ? 0.0 : driven_m(trajectory).back();
}

Result<double> middle_entropy_nat(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const Sharpness sharpness,
                   measure_sharpness(ctx, {}, middle_of(drive, trajectory), middle_of(trajectory)));
  return sharpness.of_map.mean_entropy_nat;
}

bool is_sharper(double after_nat, double before_nat) {
  return after_nat < before_nat - kSharper_nat;
}

Result<std::optional<Drive>> sharpest_sweep(PassContext& ctx, const Drive& drive,
                                            const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const std::vector<Drive> sweeps, swept_drives(drive, trajectory));
  std::optional<Drive> best;
  if (sweeps.size() == 1) best = sweeps.front();
  if (sweeps.size() < 2) return best;
  double least_nat = std::numeric_limits<double>::infinity();
  for (const Drive& swept : sweeps) {
    SIGHTLINE_ASSIGN(const double nat,
                     middle_entropy_nat(ctx, undistorted(swept, trajectory), trajectory));
    if (nat >= least_nat) continue;
    least_nat = nat;
    best = swept;
  }
  return best;
}

Result<bool> is_sharper_undistorted(PassContext& ctx, const Drive& drive, const Drive& undistorted,
                                    const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const double before_nat, middle_entropy_nat(ctx, drive, trajectory));
  SIGHTLINE_ASSIGN(const double after_nat, middle_entropy_nat(ctx, undistorted, trajectory));
  return is_sharper(after_nat, before_nat);
}

}  // namespace sightline
