#include "passes/trajectory/local/stretch_of_drive.h"

#include <memory>
#include <optional>
#include <utility>

namespace sightline {
namespace {

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
