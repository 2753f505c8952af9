#include "formats/foreign/recording/open_recording.h"

#include <algorithm>
#include <limits>
#include <span>

#include "formats/base/files/atomic_file.h"
#include "formats/base/parallel.h"
#include "formats/base/units.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/open_scan_container.h"
#include "formats/foreign/recording/recorded_turns.h"
#include "formats/foreign/recording/remembered_digests.h"
#include "formats/foreign/recording/scan_association.h"
#include "formats/foreign/recording/scan_columns.h"
#include "formats/foreign/recording/scan_files.h"
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

bool has_no_headers(const Recording& recording) {
  return !recording.container && is_without_header(recording.file_of(recording.scans.front()));
}

// Every file is read once here, so that the digest names what later passes will see.
Result<void> read_digests(Recording& recording, int threads) {
  const bool needs_columns = has_no_headers(recording);
  std::vector<FloatEvidence> evidence(needs_columns ? recording.scans.size() : 0);
  const auto take = [&](std::size_t i) -> Result<void> {
    RecordedScan& scan = recording.scans[i];
    const std::filesystem::path path = recording.file_of(scan);
    SIGHTLINE_ASSIGN(const FileContent file, read_file_content(path));
    scan.content = sha256(file.bytes());
    scan.content_xxh3 = xxh3(file.bytes());
    if (!needs_columns) return {};
    SIGHTLINE_ASSIGN(evidence[i], float_evidence(file.bytes(), path, recording.columns));
    return {};
  };
  std::vector<std::optional<Error>> failures(recording.scans.size());
  parallel_for(recording.scans.size(), threads, [&](std::size_t i) {
    const Result<void> taken = take(i);
    if (!taken) failures[i] = taken.error();
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return needs_columns ? settle_columns(evidence, recording) : Result<void>();
}

// A file of many scans was read when it was opened.
Result<void> take_digests(Recording& recording, int threads, const DigestMemory* memory) {
  if (recording.container) {
    for (std::size_t i = 0; i < recording.scans.size(); ++i) {
      recording.scans[i].content = recording.container->scans()[i].content;
    }
    return {};
  }
  // Before a file is read: a later writer leaves another state behind.
  const std::optional<Digest> state = memory != nullptr ? state_of_files(recording) : std::nullopt;
  if (state && recall_digests(*memory, *state, recording)) return {};
  const std::size_t first_warning = recording.warnings.size();
  SIGHTLINE_TRY(read_digests(recording, threads));
  if (state) remember_digests(*memory, *state, recording, first_warning);
  return {};
}

Digest digest_of(const Recording& recording) {
  ByteWriter writer;
  writer.put_string(recording.name);
  encode(recording.sensor, writer);
  for (const RecordedScan& scan : recording.scans) {
    writer.put_string(scan.name);
    writer.put(scan.stamp_ns);
    writer.put_array(std::span<const std::uint8_t>(scan.content));
    writer.put<std::uint8_t>(scan.T_world_vehicle ? 1 : 0);
    if (scan.T_world_vehicle) encode(*scan.T_world_vehicle, writer);
  }
  // KITTI's are what digests have always meant.
  const bool is_kitti = !recording.columns || *recording.columns == FloatColumns();
  if (!is_kitti) writer.put_string(to_text(*recording.columns));
  // The scans may say that they are read in the wrong order.
  if (recording.has_quaternions) writer.put_string("quaternions");
  if (!recording.turn_rates.empty()) writer.put_string("turn rates");
  for (const TurnRate& rate : recording.turn_rates) {
    writer.put(rate.stamp_ns);
    for (int axis = 0; axis < 3; ++axis) writer.put(rate.rate_rad_per_s[axis]);
  }
  return sha256(writer.bytes());
}

Error changed(const std::filesystem::path& path) {
  return {ErrorCode::kMismatchedInputs,
          "the file is not the one that was there when the recording was opened", path.string()};
}

Result<PointCloudFile> read_contained(const Recording& recording, const ScanInFile& scan,
                                      std::size_t index) {
  const std::filesystem::path path = recording.file_of(scan);
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, recording.container->read(index));
  if (sha256(bytes) != scan.content) return changed(path);
  SIGHTLINE_ASSIGN(PointCloudFile cloud, recording.container->parse(bytes, index));
  return with_returns(std::move(cloud), path.string(), "scan " + std::to_string(index));
}

Result<PointCloudFile> read_alone(const Recording& recording, const ScanInFile& scan) {
  const std::filesystem::path path = recording.file_of(scan);
  SIGHTLINE_ASSIGN(const FileContent file, read_file_content(path));
  if (xxh3(file.bytes()) != scan.content_xxh3) return changed(path);
  return parse_point_cloud(file.bytes(), path, recording.columns);
}

Result<PointCloudFile> read_checked(const Recording& recording, const ScanInFile& scan,
                                    std::size_t index) {
  return recording.container ? read_contained(recording, scan, index) : read_alone(recording, scan);
}

// Offsets from the stamp. A clock far from that of the stamps gives only the times between points.
void count_from(std::int64_t stamp_ns, PointCloudFile& cloud) {
  constexpr std::int64_t kNear_ns = 2 * kSecond_ns;
  constexpr std::int64_t kMost_ns = std::numeric_limits<std::int32_t>::max();
  if (!cloud.time_origin_ns || cloud.time_offset_ns.empty()) return;
  const std::int64_t shift_ns = *cloud.time_origin_ns - stamp_ns;
  const auto [first_ns, last_ns] = std::ranges::minmax(cloud.time_offset_ns);
  const bool is_same_clock =
      shift_ns >= -kNear_ns && shift_ns <= kNear_ns && shift_ns + last_ns <= kMost_ns;
  const auto add_ns = static_cast<std::int32_t>(is_same_clock ? shift_ns : -first_ns);
  for (std::int32_t& offset_ns : cloud.time_offset_ns) offset_ns += add_ns;
}

class RecordedScanStore : public ScanStore {
 public:
  explicit RecordedScanStore(const Recording& recording)
      : scans_(recording.scans.begin(), recording.scans.end()) {
    opened_.source = recording.source;
    opened_.container = recording.container;
    opened_.columns = recording.columns;
    opened_.digest = recording.digest;
  }

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    const ScanInFile& scan = scans_[index];
    SIGHTLINE_ASSIGN(PointCloudFile cloud, read_checked(opened_, scan, index));
    count_from(scan.stamp_ns, cloud);
    return Scan{scan.stamp_ns, std::move(cloud.points_m), std::move(cloud.time_offset_ns)};
  }

  // A scan in a file of its own is the same in another recording. How one in a file of many is read
  // may depend on what else that holds.
  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    const ScanInFile& scan = scans_[index];
    ByteWriter writer;
    if (opened_.container) {
      writer.put<std::uint64_t>(index);
      return derived_digest("scan of a file", opened_.digest, writer.bytes());
    }
    writer.put(scan.stamp_ns);
    // By which it is read; of "12.pcd.gz" both parts.
    const std::filesystem::path file = scan.name;
    const bool is_packed = file.extension() == ".gz";
    writer.put_string(is_packed ? file.stem().extension().string() : "");
    writer.put_string(file.extension().string());
    writer.put_string(opened_.columns ? to_text(*opened_.columns) : "");
    return derived_digest("scan", scan.content, writer.bytes());
  }

 private:
  std::vector<ScanInFile> scans_;
  Recording opened_;  // without its scans, whose poses would be the most of it
};

// The scans' files, or names of the parts of the one file that holds them.
Result<std::vector<std::filesystem::path>> list_scans(const RecordingOptions& options,
                                                      Recording& recording) {
  if (!is_scan_container(options.scans)) {
    if (options.topic.empty()) return list_scan_files(options.scans);
    return Error{ErrorCode::kBadValue, "topic is for bags, found " + options.scans};
  }
  SIGHTLINE_ASSIGN(std::shared_ptr<const ScanContainer> container,
                   open_scan_container(options.scans, options.topic,
                                       is_sensor_file(options.sensor) ? options.sensor : ""));
  recording.container = std::move(container);
  recording.warnings = recording.container->warnings();
  return std::vector<std::filesystem::path>(recording.container->scans().size(), options.scans);
}

Result<void> take_columns(const RecordingOptions& options, Recording& recording) {
  if (options.columns.empty()) return {};
  if (!has_no_headers(recording)) {
    return Error{ErrorCode::kBadValue,
                 "columns is for .bin scans, which do not say it themselves; found " +
                     recording.scans.front().name};
  }
  SIGHTLINE_ASSIGN(recording.columns, parse_float_columns(options.columns));
  return {};
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
    return Error{ErrorCode::kBadValue,
                 "the poses are the sensor's own, so its place in the vehicle (lidar_x_m, ...) has "
                 "no meaning"};
  }
  SIGHTLINE_TRY(validate(profile));
  return profile;
}

Result<Recording> list_recording(const RecordingOptions& options) {
  const std::filesystem::path folder = options.scans;
  Recording recording;
  const std::filesystem::path last =
      folder.has_filename() ? folder.filename() : folder.parent_path().filename();
  recording.name = options.name.empty() ? last.string() : options.name;
  recording.source = folder;
  SIGHTLINE_ASSIGN(SensorProfile sensor, sensor_of(options));
  recording.sensor = std::move(sensor);
  SIGHTLINE_ASSIGN(const std::vector<std::filesystem::path> files, list_scans(options, recording));
  SIGHTLINE_TRY(describe_scans(options, files, recording));
  SIGHTLINE_TRY(take_columns(options, recording));
  return recording;
}

Result<Recording> open_recording(const RecordingOptions& options, int threads,
                                 const DigestMemory* memory) {
  SIGHTLINE_ASSIGN(Recording recording, list_recording(options));
  SIGHTLINE_TRY(take_turn_rates(options, recording));
  SIGHTLINE_TRY(take_digests(recording, threads, memory));
  recording.digest = digest_of(recording);
  return recording;
}

Result<PointCloudFile> read_recorded_scan(const Recording& recording, std::size_t index) {
  SIGHTLINE_CHECK(index < recording.scans.size());
  return read_checked(recording, recording.scans[index], index);
}

Result<PointCloudFile> read_listed_scan(const Recording& recording, std::size_t index) {
  SIGHTLINE_CHECK(index < recording.scans.size());
  if (!recording.container) {
    return read_point_cloud(recording.file_of(recording.scans[index]), recording.columns);
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, recording.container->read(index));
  return recording.container->parse(bytes, index);
}

std::shared_ptr<const ScanStore> recorded_scan_store(const Recording& recording) {
  auto store = std::make_shared<const RecordedScanStore>(recording);
  return recording.memory ? ScanMemory::before(std::move(store), recording.memory) : store;
}

}  // namespace sightline
