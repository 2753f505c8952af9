#include "formats/foreign/recording.h"

#include <numbers>
#include <span>

#include "compiler/base/atomic_file.h"
#include "compiler/base/parallel.h"
#include "formats/foreign/scan_association.h"
#include "formats/foreign/scan_files.h"

namespace sightline {
namespace {

Pose mounting(const RecordingOptions& options) {
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.translate(
      Eigen::Vector3d(options.lidar_x_m, options.lidar_y_m, options.lidar_z_m));
  T_vehicle_lidar.rotate(
      Eigen::AngleAxisd(options.lidar_yaw_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()));
  T_vehicle_lidar.rotate(
      Eigen::AngleAxisd(options.lidar_pitch_deg * kRadPerDeg, Eigen::Vector3d::UnitY()));
  T_vehicle_lidar.rotate(
      Eigen::AngleAxisd(options.lidar_roll_deg * kRadPerDeg, Eigen::Vector3d::UnitX()));
  return T_vehicle_lidar;
}

Result<SensorProfile> sensor_of(const RecordingOptions& options) {
  Result<SensorProfile> profile = sensor_profile(options.sensor);
  if (!profile) return profile;
  if (options.rings == 1 || options.rings < 0 ||
      options.lowest_beam_deg >= options.highest_beam_deg) {
    return Error{ErrorCode::kBadValue,
                 "rings must be 0 or at least 2, and lowest_beam_deg below highest_beam_deg", "",
                 ""};
  }
  if (options.rings > 0) {
    profile->name.append("-").append(std::to_string(options.rings)).append("-rings");
    profile->beam_elevations_deg.clear();
    for (int i = 0; i < options.rings; ++i) {
      profile->beam_elevations_deg.push_back(options.lowest_beam_deg +
                                             (options.highest_beam_deg - options.lowest_beam_deg) *
                                                 i / (options.rings - 1));
    }
  }
  if (options.height_m != 0.0) profile->height_m = options.height_m;
  profile->T_vehicle_lidar = mounting(options);
  if (options.poses_of != "vehicle" && options.poses_of != "sensor") {
    return Error{ErrorCode::kUnknownName,
                 "poses_of is '" + options.poses_of + "', expected vehicle or sensor", "", ""};
  }
  if (options.poses_of == "sensor" && !profile->T_vehicle_lidar.isApprox(Pose::Identity(), 0.0)) {
    return Error{ErrorCode::kBadValue,
                 "the poses are the sensor's own, so its place in the vehicle (lidar_x_m, ...) has "
                 "no meaning",
                 "", ""};
  }
  const Result<void> valid = validate(*profile);
  if (!valid) return valid.error();
  return profile;
}

// Every file is read once here, so that the digest names what later passes will see.
Result<void> take_digests(Recording& recording, int threads) {
  std::vector<std::optional<Error>> failures(recording.scans.size());
  parallel_for(recording.scans.size(), threads, [&](std::size_t i) {
    const Result<std::vector<std::byte>> bytes = read_file(recording.scans[i].file);
    if (bytes) {
      recording.scans[i].content = sha256(*bytes);
    } else {
      failures[i] = bytes.error();
    }
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return {};
}

Digest digest_of(const Recording& recording) {
  ByteWriter writer;
  writer.put_string(recording.name);
  encode(recording.sensor, writer);
  for (const RecordedScan& scan : recording.scans) {
    writer.put_string(scan.file.filename().string());
    writer.put(scan.stamp_ns);
    writer.put_array(std::span<const std::uint8_t>(scan.content));
    writer.put<std::uint8_t>(scan.T_world_vehicle ? 1 : 0);
    if (scan.T_world_vehicle) encode(*scan.T_world_vehicle, writer);
  }
  return sha256(writer.bytes());
}

Result<PointCloudFile> read_checked(const RecordedScan& scan) {
  const Result<std::vector<std::byte>> bytes = read_file(scan.file);
  if (!bytes) return bytes.error();
  if (sha256(*bytes) != scan.content) {
    return Error{ErrorCode::kMismatchedInputs,
                 "the file is not the one that was there when the recording was opened",
                 scan.file.string(), ""};
  }
  return parse_point_cloud(*bytes, scan.file);
}

class RecordedScanStore : public ScanStore {
 public:
  explicit RecordedScanStore(std::vector<RecordedScan> scans) : scans_(std::move(scans)) {}

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    Result<PointCloudFile> cloud = read_checked(scans_[index]);
    if (!cloud) return cloud.error();
    return Scan{scans_[index].stamp_ns, std::move(cloud->points_m)};
  }

 private:
  std::vector<RecordedScan> scans_;
};

}  // namespace

Result<Recording> open_recording(const RecordingOptions& options, int threads) {
  const std::filesystem::path folder = options.scans;
  Recording recording;
  const std::filesystem::path last =
      folder.has_filename() ? folder.filename() : folder.parent_path().filename();
  recording.name = options.name.empty() ? last.string() : options.name;
  Result<SensorProfile> sensor = sensor_of(options);
  if (!sensor) return sensor.error();
  recording.sensor = std::move(*sensor);
  const Result<std::vector<std::filesystem::path>> files = list_scan_files(folder);
  if (!files) return files.error();
  const Result<void> described = describe_scans(options, *files, recording);
  if (!described) return described.error();
  const Result<void> digested = take_digests(recording, threads);
  if (!digested) return digested.error();
  recording.digest = digest_of(recording);
  return recording;
}

Result<PointCloudFile> read_recorded_scan(const Recording& recording, std::size_t index) {
  SIGHTLINE_CHECK(index < recording.scans.size());
  return read_checked(recording.scans[index]);
}

std::shared_ptr<const ScanStore> recorded_scan_store(const Recording& recording) {
  return std::make_shared<RecordedScanStore>(recording.scans);
}

Result<void> validate(const Recording& recording) {
  if (!recording.scans.empty()) return {};
  return Error{ErrorCode::kInvalidArtifact, "a recording without scans", "", recording.name};
}

Table dump(const Recording& recording) {
  Table table{"recording", {"scan", "file", "stamp_ns", "has_pose", "content_sha256"}, {}, {}};
  table.facts = {{"name", recording.name}, {"sensor", recording.sensor.name}};
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const RecordedScan& scan = recording.scans[i];
    table.rows.push_back({static_cast<std::int64_t>(i), scan.file.filename().string(),
                          scan.stamp_ns, std::int64_t{scan.T_world_vehicle ? 1 : 0},
                          to_hex(scan.content)});
  }
  return table;
}

}  // namespace sightline
