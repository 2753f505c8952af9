#include "passes/trajectory/swept_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "passes/map/measure_sharpness.h"
#include "passes/trajectory/sweep_times.h"
#include "passes/trajectory/undistort_scans.h"

// A scan of 0.1 s at 10 m/s is drawn out by 1 m, and where its sweep begins the world tears. Poses
// of such scans taken as rigid are off by what the tear does to a match, so undistorting with them
// sharpens little; poses estimated from the undistorted scans do not have that error any more.
// Files do not say whether somebody undistorted the scans already, nor does their order. The scans
// say it: undistorted twice they no longer fit each other.

namespace sightline {
namespace {

constexpr std::int64_t kLongestSweep_ns = 100'000'000;  // 10 Hz; slower LiDARs are rare
// The trial takes the middle of a drive: enough way that things are seen from several sides.
constexpr std::size_t kTrialScans = 60;
// Entropies of two ways to lay a drive differ by a few hundredths where nothing is gained.
constexpr double kSharper_nat = 0.05;
constexpr int kRounds = 2;

std::int64_t sweep_ns(const Drive& drive) {
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    steps_ns.push_back(drive.scans[i].stamp_ns - drive.scans[i - 1].stamp_ns);
  }
  std::ranges::sort(steps_ns);
  return std::min(kLongestSweep_ns, steps_ns[steps_ns.size() / 2]);
}

class SweptScanStore : public ScanStore {
 public:
  SweptScanStore(std::shared_ptr<const ScanStore> store, std::int64_t sweep_ns)
      : store_(std::move(store)), sweep_ns_(sweep_ns) {}

  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = store_->read(index);
    if (!scan) return scan;
    for (const double time : sweep_times(scan->points_m)) {
      const double offset_ns = (time - 0.5) * static_cast<double>(sweep_ns_);
      scan->time_offset_ns.push_back(static_cast<std::int32_t>(std::floor(offset_ns)));
    }
    return scan;
  }

 private:
  std::shared_ptr<const ScanStore> store_;
  std::int64_t sweep_ns_;
};

// A stretch of a drive, counted from 0 anew.
class StretchStore : public ScanStore {
 public:
  StretchStore(std::shared_ptr<const ScanStore> store, std::size_t first)
      : store_(std::move(store)), first_(first) {}
  Result<Scan> read(std::size_t index) const override { return store_->read(first_ + index); }

 private:
  std::shared_ptr<const ScanStore> store_;
  std::size_t first_;
};

std::size_t first_of_middle(const Drive& drive) {
  return drive.scans.size() <= kTrialScans ? 0 : (drive.scans.size() - kTrialScans) / 2;
}

Drive middle_of(const Drive& drive) {
  const std::size_t first = first_of_middle(drive);
  const std::size_t count = std::min(kTrialScans, drive.scans.size());
  Drive middle = with_store(drive, std::make_shared<const StretchStore>(drive.store, first));
  middle.scans = {drive.scans.begin() + static_cast<std::ptrdiff_t>(first),
                  drive.scans.begin() + static_cast<std::ptrdiff_t>(first + count)};
  return middle;
}

Trajectory middle_of(const Trajectory& trajectory, const Drive& drive) {
  const auto first = static_cast<std::ptrdiff_t>(first_of_middle(drive));
  Trajectory middle = trajectory;
  middle.poses = {trajectory.poses.begin() + first,
                  trajectory.poses.begin() + first +
                      static_cast<std::ptrdiff_t>(std::min(kTrialScans, drive.scans.size()))};
  return middle;
}

Result<double> entropy_nat(PassContext& ctx, const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const Sharpness sharpness,
                   measure_sharpness(ctx, {}, middle_of(drive), middle_of(trajectory, drive)));
  return sharpness.of_map.mean_entropy_nat;
}

Result<Trajectory> estimate_again(PassContext& ctx, const Drive& timed, Trajectory trajectory,
                                  const EstimatePoses& estimate) {
  for (int round = 0; round < kRounds; ++round) {
    SIGHTLINE_ASSIGN(trajectory, estimate(ctx, undistorted(timed, trajectory)));
  }
  return trajectory;
}

}  // namespace

Result<Drive> with_sweep_times(const Drive& drive) {
  const bool has_times =
      std::ranges::any_of(drive.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  if (has_times || !drive.other_sensors.empty() || drive.scans.size() < 2) return drive;
  for (const std::size_t index : {std::size_t{0}, drive.scans.size() / 2}) {
    SIGHTLINE_ASSIGN(const Scan scan, drive.store->read(index));
    if (sweep_times(scan.points_m).empty()) return drive;
  }
  Drive swept =
      with_store(drive, std::make_shared<const SweptScanStore>(drive.store, sweep_ns(drive)));
  for (ScanInfo& scan : swept.scans) scan.has_point_times = true;
  return swept;
}

Result<Trajectory> estimate_undistorted(PassContext& ctx, const Drive& drive,
                                        const Trajectory& rigid, const EstimatePoses& estimate) {
  SIGHTLINE_ASSIGN(const Drive timed, with_sweep_times(drive));
  const bool has_times =
      std::ranges::any_of(timed.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  if (!has_times) return rigid;
  PassContext quiet;
  quiet.threads = ctx.threads;
  quiet.seed = ctx.seed;
  const Drive middle = middle_of(timed);
  const Trajectory before = middle_of(rigid, timed);
  const Result<Trajectory> after = estimate_again(quiet, middle, before, estimate);
  // A trial that fails says nothing for undistorting.
  if (!after) return rigid;
  SIGHTLINE_ASSIGN(const double before_nat, entropy_nat(quiet, middle, before));
  SIGHTLINE_ASSIGN(const double after_nat, entropy_nat(quiet, undistorted(middle, *after), *after));
  if (after_nat >= before_nat - kSharper_nat) return rigid;
  if (middle.scans.size() == timed.scans.size()) return after;
  return estimate_again(quiet, timed, rigid, estimate);
}

Result<bool> is_sharper_undistorted(PassContext& ctx, const Drive& drive, const Drive& undistorted,
                                    const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const double before_nat, entropy_nat(ctx, drive, trajectory));
  SIGHTLINE_ASSIGN(const double after_nat, entropy_nat(ctx, undistorted, trajectory));
  return after_nat < before_nat - kSharper_nat;
}

}  // namespace sightline
