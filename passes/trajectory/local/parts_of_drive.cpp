#include "passes/trajectory/local/parts_of_drive.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "formats/drive/scan_stores.h"

namespace sightline {
namespace {

// The rates before `end_ns`, from `first` on; moves `first` behind them.
std::vector<TurnRate> rates_until(const std::vector<TurnRate>& rates, std::int64_t end_ns,
                                  std::size_t& first) {
  const std::size_t begin = first;
  while (first < rates.size() && rates[first].stamp_ns < end_ns) ++first;
  return {rates.begin() + static_cast<std::ptrdiff_t>(begin),
          rates.begin() + static_cast<std::ptrdiff_t>(first)};
}

class StretchStore : public ScanStore {
 public:
  StretchStore(std::shared_ptr<const ScanStore> store, std::size_t first)
      : store_(std::move(store)), first_(first) {}
  Result<Scan> read(std::size_t index) const override { return store_->read(first_ + index); }
  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    return store_->identity(first_ + index);
  }

 private:
  std::shared_ptr<const ScanStore> store_;
  std::size_t first_;
};

}  // namespace

std::vector<Drive> parts_of(const Drive& drive) {
  if (drive.later_parts.empty() || drive.scans.empty()) return {drive};
  std::vector<Drive> parts;
  std::size_t first_rate = 0;
  for (std::size_t begin = 0; begin < drive.scans.size();) {
    std::size_t end = begin + 1;
    while (end < drive.scans.size() && drive.scans[end].part == drive.scans[begin].part) ++end;
    Drive& part = parts.emplace_back(stretch_of(drive, begin, end - begin));
    part.name = drive.name_of_part(drive.scans[begin].part);
    part.later_parts.clear();
    for (ScanInfo& scan : part.scans) scan.part = 0;
    const std::int64_t end_ns =
        end < drive.scans.size()
            ? std::midpoint(drive.scans[end - 1].stamp_ns, drive.scans[end].stamp_ns)
            : std::numeric_limits<std::int64_t>::max();
    part.turn_rates = rates_until(drive.turn_rates, end_ns, first_rate);
    begin = end;
  }
  return parts;
}

std::vector<Trajectory> trajectories_of_parts(const std::vector<Drive>& parts,
                                              const Trajectory& trajectory) {
  std::vector<Trajectory> of_parts;
  auto begin = trajectory.poses.begin();
  for (const Drive& part : parts) {
    const auto end = begin + static_cast<std::ptrdiff_t>(part.scans.size());
    of_parts.push_back(trajectory);
    of_parts.back().poses = {begin, end};
    begin = end;
  }
  return of_parts;
}

Drive joined_again(const Drive& drive, const std::vector<Drive>& parts) {
  if (drive.later_parts.empty()) return parts.front();
  std::vector<std::shared_ptr<const ScanStore>> stores;
  std::vector<ScanOrigin> origins;
  std::vector<TurnRate> rates;
  std::vector<ScanInfo> scans = drive.scans;
  for (const Drive& part : parts) {
    for (std::size_t i = 0; i < part.scans.size(); ++i) {
      scans[origins.size()].has_point_times = part.scans[i].has_point_times;
      origins.push_back({stores.size(), i});
    }
    stores.push_back(part.store);
    rates.insert(rates.end(), part.turn_rates.begin(), part.turn_rates.end());
  }
  Drive joined = with_store(drive, joined_scan_store(std::move(stores), std::move(origins)));
  joined.scans = std::move(scans);
  joined.turn_rates = std::move(rates);
  return joined;
}

Result<Drive> change_parts(const Drive& drive, const Trajectory& trajectory,
                           const ChangePart& change) {
  std::vector<Drive> parts = parts_of(drive);
  const std::vector<Trajectory> poses = trajectories_of_parts(parts, trajectory);
  bool is_changed = false;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    SIGHTLINE_ASSIGN(std::optional<Drive> changed, change(parts[i], poses[i]));
    if (!changed) continue;
    parts[i] = *std::move(changed);
    is_changed = true;
  }
  return is_changed ? joined_again(drive, parts) : drive;
}

Drive stretch_of(const Drive& drive, std::size_t first, std::size_t count) {
  Drive stretch = with_store(drive, std::make_shared<const StretchStore>(drive.store, first));
  const auto begin = drive.scans.begin() + static_cast<std::ptrdiff_t>(first);
  stretch.scans = {begin, begin + static_cast<std::ptrdiff_t>(count)};
  return stretch;
}

Trajectory stretch_of(const Trajectory& trajectory, std::size_t first, std::size_t count) {
  Trajectory stretch = trajectory;
  const auto begin = trajectory.poses.begin() + static_cast<std::ptrdiff_t>(first);
  stretch.poses = {begin, begin + static_cast<std::ptrdiff_t>(count)};
  const std::uint32_t first_piece = stretch.poses.empty() ? 0 : stretch.poses.front().piece;
  for (TrajectoryPose& pose : stretch.poses) pose.piece -= first_piece;
  return stretch;
}

std::vector<Pose> sensor_poses(const Drive& drive, const Trajectory& trajectory) {
  std::vector<Pose> T_map_lidar;
  for (const TrajectoryPose& pose : trajectory.poses) {
    T_map_lidar.push_back(pose.T_map_vehicle * drive.sensor.T_vehicle_lidar);
  }
  return T_map_lidar;
}

}  // namespace sightline
