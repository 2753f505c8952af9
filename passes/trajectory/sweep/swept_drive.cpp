#include "passes/trajectory/sweep/swept_drive.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "passes/trajectory/sweep/sweep_times.h"
#include "passes/trajectory/sweep/sweep_turn.h"

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

}  // namespace sightline
