#include "formats/foreign/recording/recorded_turns.h"

#include <algorithm>
#include <string>

#include "formats/base/units.h"
#include "formats/foreign/ros/bag_turns.h"
#include "formats/foreign/ros/ros_bag.h"

namespace sightline {

Result<void> take_turn_rates(const RecordingOptions& options, Recording& recording) {
  constexpr std::int64_t kBeyond_ns = kSecond_ns;
  if (options.imu_topic == kNoImu) return {};
  if (!is_ros_bag(options.scans)) {
    if (options.imu_topic.empty()) return {};
    return Error{ErrorCode::kBadValue, "imu_topic is for scans in bags, found " + options.scans};
  }
  SIGHTLINE_ASSIGN(const BagTurns turns,
                   read_bag_turns(options.scans, options.imu_topic, recording.container->frame()));
  recording.warnings.insert(recording.warnings.end(), turns.warnings.begin(), turns.warnings.end());
  if (recording.scans.empty()) return {};
  const auto [first, last] = std::ranges::minmax(recording.scans, {}, &RecordedScan::stamp_ns);
  const Eigen::Matrix3d R_vehicle_sensor = recording.sensor.T_vehicle_lidar.linear();
  for (const TurnRate& rate : turns.of_sensor) {
    const bool is_within =
        rate.stamp_ns >= first.stamp_ns - kBeyond_ns && rate.stamp_ns <= last.stamp_ns + kBeyond_ns;
    if (!is_within) continue;
    const Eigen::Vector3d of_vehicle = R_vehicle_sensor * rate.rate_rad_per_s;
    recording.turn_rates.push_back({rate.stamp_ns, of_vehicle});
  }
  if (!turns.of_sensor.empty() && recording.turn_rates.empty()) {
    recording.warnings.push_back(options.scans + ": turn rates are not used: none of the " +
                                 std::to_string(turns.of_sensor.size()) +
                                 " is at the time of a scan");
  }
  return {};
}

}  // namespace sightline
