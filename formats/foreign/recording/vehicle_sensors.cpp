#include "formats/foreign/recording/vehicle_sensors.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/units.h"
#include "formats/foreign/ros/ros_bag.h"

namespace sightline {
namespace {

// Whether the topic of a key is read. Error: bad-value.
Result<bool> is_read(const RecordingOptions& options, const std::string& key,
                     const std::string& topic) {
  if (topic == "none") return false;
  if (is_ros_bag(options.scans)) return true;
  if (topic.empty()) return false;
  return Error{ErrorCode::kBadValue,
               concat(key, " is only for scans in bags, found ", options.scans)};
}

// Samples near the times of scans; `what` they are, for the warning where none is.
template <class Sample>
std::vector<Sample> within_scans(const std::vector<Sample>& samples, const std::string& what,
                                 Recording& recording) {
  constexpr std::int64_t kBeyond_ns = kSecond_ns;
  std::vector<Sample> within;
  if (recording.scans.empty() || samples.empty()) return within;
  const auto [first, last] = std::ranges::minmax(recording.scans, {}, &RecordedScan::stamp_ns);
  for (const Sample& sample : samples) {
    const bool is_within = sample.stamp_ns >= first.stamp_ns - kBeyond_ns &&
                           sample.stamp_ns <= last.stamp_ns + kBeyond_ns;
    if (is_within) within.push_back(sample);
  }
  if (within.empty()) {
    recording.warnings.push_back(concat(recording.source.string(), ": ", what,
                                        " are not used: none of the ", samples.size(),
                                        " is within the time of a scan"));
  }
  return within;
}

}  // namespace

Result<void> take_inertial_unit(const RecordingOptions& options, Recording& recording) {
  SIGHTLINE_ASSIGN(const bool reads, is_read(options, "imu_topic", options.imu_topic));
  if (!reads) return {};
  SIGHTLINE_ASSIGN(const BagTurns unit,
                   read_bag_turns(options.scans, options.imu_topic, recording.container->frame()));
  recording.warnings.insert(recording.warnings.end(), unit.warnings.begin(), unit.warnings.end());
  recording.turn_rates = within_scans(unit.of_sensor, "turn rates", recording);
  if (!recording.turn_rates.empty()) {
    recording.specific_forces = within_scans(unit.forces_of_sensor, "accelerations", recording);
  }
  const Eigen::Matrix3d R_vehicle_sensor = recording.sensor.T_vehicle_lidar.linear();
  for (TurnRate& rate : recording.turn_rates) {
    rate.rate_rad_per_s = R_vehicle_sensor * rate.rate_rad_per_s;
  }
  for (SpecificForce& force : recording.specific_forces) {
    force.force_m_s2 = R_vehicle_sensor * force.force_m_s2;
  }
  return {};
}

Result<void> take_wheel_speeds(const RecordingOptions& options, Recording& recording) {
  SIGHTLINE_ASSIGN(const bool reads, is_read(options, "wheel_speed", options.wheel_speed));
  if (!reads) return {};
  SIGHTLINE_ASSIGN(const BagSpeeds speeds, read_bag_speeds(options.scans, options.wheel_speed));
  recording.warnings.insert(recording.warnings.end(), speeds.warnings.begin(),
                            speeds.warnings.end());
  recording.wheel_speeds = within_scans(speeds.speeds, "wheel speeds", recording);
  if (!recording.wheel_speeds.empty()) {
    recording.remarks.push_back(concat("wheel speeds are those of ", speeds.topic, " (",
                                       speeds.type, ", ", recording.wheel_speeds.size(),
                                       " messages)"));
  }
  if (!speeds.remark.empty()) recording.remarks.push_back(speeds.remark);
  return {};
}

}  // namespace sightline
