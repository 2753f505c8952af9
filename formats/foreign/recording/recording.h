#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/scan_stores.h"
#include "formats/foreign/clouds/float_columns.h"
#include "formats/foreign/logs/scan_container.h"
#include "formats/foreign/text/pose_file.h"

namespace sightline {

enum class PosesOf { kVehicle, kSensor };

struct RecordingOptions {
  std::string name;   // of the drive; empty: the last part of `scans`
  std::string scans;  // folder with one point cloud file per scan, or a file of many
  std::string topic;  // of a bag's scans; empty: its only one
  // Columns of scans without a header (parse_float_columns); empty: see open_recording.
  std::string columns;
  std::string poses;        // pose file or bag; empty: there are none
  std::string poses_topic;  // of a bag's poses; empty: its only one
  std::string imu_topic;    // of a bag's inertial unit; empty: see read_bag_turns
  std::string wheel_speed;  // topic of a bag; empty: see read_bag_speeds
  PoseFormat pose_format = PoseFormat::kAuto;  // or kitti, tum, apollo
  PosesOf poses_of = PosesOf::kVehicle;        // kSensor: the mounting below does not apply
  // KITTI's calibration, which takes poses of its camera or its inertial unit to the sensor
  // (dataset_poses.h); empty: there is none.
  std::string calibration;
  // Where world coordinates lie (parse_world), for poses in degrees; "local": east, north and up at
  // the first of them.
  std::string world = "local";
  std::string stamps;                 // file with one time a line; empty: see open_recording
  double rate_hz = 10.0;              // scans a second, where their times are unknown
  std::string sensor = "generic-16";  // name of a built-in profile, or a file (sensor_file.h)
  int rings = 0;                      // 0: the profile's own beams; else this many, evenly from
  double lowest_beam_deg = -15.0;     // here
  double highest_beam_deg = 15.0;     // to here
  double azimuth_view_deg = 0.0;      // what the sensor sees of a turn; 0: the profile's own
  double height_m = 0.0;              // of the sensor above ground; 0: the profile's own
  // Where the sensor sits in the vehicle's frame: T_vehicle_lidar = translation * Rz(yaw) Ry(pitch)
  // Rx(roll).
  double lidar_x_m = 0.0;
  double lidar_y_m = 0.0;
  double lidar_z_m = 0.0;
  double lidar_roll_deg = 0.0;
  double lidar_pitch_deg = 0.0;
  double lidar_yaw_deg = 0.0;
  // Of a drive that is localized in a map: a constant offset of its poses from the map's is
  // subtracted.
  bool align = false;
};

// The sensor that the options describe. Errors: unknown-name, bad-value, and those of validate.
Result<SensorProfile> sensor_of(const RecordingOptions& options);

// What it takes to read a scan again.
struct ScanInFile {
  std::string name;  // of its file; "drive.bag#12" in a file of many scans
  std::int64_t stamp_ns = 0;
  Digest content{};  // SHA-256 of the file, or of what a file of many says of this scan
  std::uint64_t content_xxh3 = 0;  // of the file; 0 in a file of many. Ten times as fast to compare
  std::uint32_t index = 0;  // among all scans of the folder or file, also those that are left out
};

struct RecordedScan : ScanInFile {
  std::optional<Pose> T_world_vehicle;
};

// Somebody's recording, opened but not read: which files, when, and from where.
struct Recording {
  std::string name;
  SensorProfile sensor;
  std::filesystem::path source;  // the folder of the scans' files, or the one file that holds them
  // In natural order of their names (2 before 10), or in the order of the file that holds them;
  // without those that are left out (left_out_scans.h).
  std::vector<RecordedScan> scans;
  std::shared_ptr<const ScanContainer> container;  // that file; nullptr: each scan has its own
  // Of scans without a header: as given, or as found when they were opened.
  std::optional<FloatColumns> columns;
  // Of a bag's inertial unit and wheels, in the vehicle's axes; empty: there are none to use.
  std::vector<TurnRate> turn_rates;
  std::vector<SpecificForce> specific_forces;
  std::vector<WheelSpeed> wheel_speeds;
  // Poses by their own times, ascending; empty where they belong to scans by row.
  std::vector<PoseRow> pose_rows;
  std::string world_frame;             // that a bag's poses are in; empty: it is not known
  bool has_quaternions = false;        // poses are quaternions of a text file, read as x y z w
  std::vector<std::string> warnings;   // what was assumed, for the person who brought it
  std::vector<std::string> remarks;    // what was chosen without a doubt; for the log
  std::shared_ptr<ScanMemory> memory;  // which keeps scans that were read; nullptr: none does
  // Names everything above but pose_rows, world_frame, warnings, remarks and memory: equal for
  // equal contents, wherever the folder lies.
  Digest digest{};

  // Which file holds a scan.
  [[nodiscard]] std::filesystem::path file_of(const ScanInFile& scan) const;
};

template <>
struct ArtifactTraits<Recording> {
  static constexpr std::string_view kName = "recording";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const Recording& recording);
Table dump(const Recording& recording);

}  // namespace sightline
