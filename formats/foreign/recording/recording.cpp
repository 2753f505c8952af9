#include "formats/foreign/recording/recording.h"

#include "formats/base/units.h"
#include "formats/foreign/text/sensor_file.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

Pose mounting(const RecordingOptions& options) {
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.translate(
      Eigen::Vector3d(options.lidar_x_m, options.lidar_y_m, options.lidar_z_m));
  const AxisAngle yaw{Eigen::Vector3d::UnitZ(), options.lidar_yaw_deg * kRadPerDeg};
  const AxisAngle pitch{Eigen::Vector3d::UnitY(), options.lidar_pitch_deg * kRadPerDeg};
  const AxisAngle roll{Eigen::Vector3d::UnitX(), options.lidar_roll_deg * kRadPerDeg};
  for (const AxisAngle& turn : {yaw, pitch, roll}) T_vehicle_lidar.rotate(rotation_matrix(turn));
  return T_vehicle_lidar;
}

}  // namespace

Result<SensorProfile> sensor_of(const RecordingOptions& options) {
  SIGHTLINE_ASSIGN(SensorProfile profile, is_sensor_file(options.sensor)
                                              ? read_sensor_file(options.sensor)
                                              : sensor_profile(options.sensor));
  if (options.rings == 1 || options.rings < 0 ||
      options.lowest_beam_deg >= options.highest_beam_deg) {
    return Error{ErrorCode::kBadValue,
                 "rings must be 0 or at least 2, and lowest_beam_deg below highest_beam_deg"};
  }
  if (options.rings > 0) {
    profile.name.append("-").append(std::to_string(options.rings)).append("-rings");
    profile.beam_elevations_deg.clear();
    for (int i = 0; i < options.rings; ++i) {
      profile.beam_elevations_deg.push_back(options.lowest_beam_deg +
                                            (options.highest_beam_deg - options.lowest_beam_deg) *
                                                i / (options.rings - 1));
    }
  }
  if (options.azimuth_view_deg != 0.0) profile.azimuth_view_deg = options.azimuth_view_deg;
  if (options.height_m != 0.0) profile.height_m = options.height_m;
  profile.T_vehicle_lidar = mounting(options);
  const bool are_of_sensor = options.poses_of == PosesOf::kSensor;
  if (are_of_sensor && !profile.T_vehicle_lidar.isApprox(Pose::Identity(), 0.0)) {
    return Error{
        ErrorCode::kBadValue,
        "the poses are those of the sensor (poses_of: sensor), so its mounting (lidar_x_m, ...) "
        "must not be given. Remove these keys, or write poses_of: vehicle"};
  }
  SIGHTLINE_TRY(validate(profile));
  return profile;
}

std::filesystem::path Recording::file_of(const ScanInFile& scan) const {
  return container ? source : source / scan.name;
}

Result<void> validate(const Recording& recording) {
  if (!recording.scans.empty()) return {};
  return Error{ErrorCode::kInvalidArtifact, "a recording without scans", "", recording.name};
}

Table dump(const Recording& recording) {
  Table table{"recording", {"scan", "file", "stamp_ns", "has_pose", "content_sha256"}, {}, {}};
  table.facts = {{"name", recording.name}, {"sensor", recording.sensor.name}};
  if (recording.columns) table.facts.emplace_back("columns", to_text(*recording.columns));
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const RecordedScan& scan = recording.scans[i];
    table.rows.push_back({static_cast<std::int64_t>(i), scan.name, scan.stamp_ns,
                          std::int64_t{scan.T_world_vehicle ? 1 : 0}, to_hex(scan.content)});
  }
  return table;
}

}  // namespace sightline
