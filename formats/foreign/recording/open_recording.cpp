#include "formats/foreign/recording/open_recording.h"

#include <algorithm>
#include <span>

#include "formats/base/files/atomic_file.h"
#include "formats/base/parallel.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/point_times.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/foreign/recording/vehicle_sensors.h"
#include "formats/foreign/text/sensor_file.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

bool has_no_headers(const Recording& recording) {
  return !recording.container && is_without_header(recording.file_of(recording.scans.front()));
}

Error of_scan(Error error, const Recording& recording, std::size_t index) {
  return in_file(std::move(error), recording.file_of(recording.scans[index]).string());
}

Result<void> check_given(const std::vector<FloatEvidence>& evidence, const Recording& recording) {
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!evidence[i].refutes) continue;
    return of_scan(
        {ErrorCode::kUnsupportedFormat,
         concat("its floats are not ", recording.columns->count, " a point (",
                to_text(*recording.columns), "); remove `columns` to see which numbers fit")},
        recording, i);
  }
  return {};
}

// What fits the scans up to here and none further.
Error mixed(const std::vector<FloatEvidence>& evidence, const Recording& recording,
            std::size_t index, FloatCounts before) {
  return {ErrorCode::kMixedFormats,
          concat("scans of different numbers of floats a point: ", counts_text(before),
                 " fit up to ", recording.scans[index - 1].name, ", ",
                 counts_text(evidence[index].fitting), " fit ", recording.scans[index].name),
          recording.file_of(recording.scans[index]).parent_path().string()};
}

Result<FloatCounts> common_counts(const std::vector<FloatEvidence>& evidence,
                                  const Recording& recording) {
  FloatCounts fitting = kAnyCount;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const FloatCounts both = fitting & evidence[i].fitting;
    if (evidence[i].fitting == 0) return of_scan(the_one_count(0, kAnyCount).error(), recording, i);
    if (both == 0) return mixed(evidence, recording, i, fitting);
    fitting = both;
  }
  return fitting;
}

// Settles the columns of scans without a header by the evidence of each file: whether one refutes
// given columns, else the count of floats a point that fits all. Warns where that is not KITTI's
// four. Errors: unsupported-format (none fits, or several, or not the given), truncated-scan,
// mixed-formats.
Result<void> settle_columns(const std::vector<FloatEvidence>& evidence, Recording& recording) {
  if (recording.columns) return check_given(evidence, recording);
  SIGHTLINE_ASSIGN(const FloatCounts fitting, common_counts(evidence, recording));
  FloatCounts dividing = kAnyCount;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    dividing &= evidence[i].dividing;
    const Result<std::size_t> count = the_one_count(fitting, dividing);
    const bool is_cut = !count && count.error().code == ErrorCode::kTruncatedScan;
    if (is_cut) return of_scan(count.error(), recording, i);
  }
  const Result<std::size_t> count = the_one_count(fitting, dividing);
  if (!count) return of_scan(count.error(), recording, 0);
  recording.columns = columns_of_count(*count);
  if (*count != FloatColumns().count) {
    recording.warnings.push_back(concat("scans have no header: ", *count,
                                        " floats a point fit; they are read as `columns: ",
                                        to_text(*recording.columns), "` (_ is ignored)"));
  }
  return {};
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
    for (RecordedScan& scan : recording.scans) {
      scan.content = recording.container->scans()[scan.index].content;
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
  if (!recording.specific_forces.empty()) writer.put_string("specific forces");
  for (const SpecificForce& force : recording.specific_forces) {
    writer.put(force.stamp_ns);
    for (int axis = 0; axis < 3; ++axis) writer.put(force.force_m_s2[axis]);
  }
  if (!recording.wheel_speeds.empty()) writer.put_string("wheel speeds");
  for (const WheelSpeed& speed : recording.wheel_speeds) {
    writer.put(speed.stamp_ns);
    writer.put(speed.speed_m_s);
  }
  return sha256(writer.bytes());
}

Error changed(const std::filesystem::path& path) {
  return {ErrorCode::kMismatchedInputs, "the file has changed since the recording was opened",
          path.string()};
}

Result<PointCloudFile> read_contained(const Recording& recording, const ScanInFile& scan) {
  const std::filesystem::path path = recording.file_of(scan);
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, recording.container->read(scan.index));
  if (sha256(bytes) != scan.content) return changed(path);
  SIGHTLINE_ASSIGN(PointCloudFile cloud, recording.container->parse(bytes, scan.index));
  return with_returns(std::move(cloud), path.string(), concat("scan ", scan.index));
}

Result<PointCloudFile> with_remedy(Result<PointCloudFile> cloud) {
  if (cloud || cloud.error().code != ErrorCode::kEmptyScan) return cloud;
  Error error = cloud.error();
  error.message += "; remove it from the folder, and its row from the poses";
  return error;
}

Result<PointCloudFile> read_alone(const Recording& recording, const ScanInFile& scan) {
  const std::filesystem::path path = recording.file_of(scan);
  SIGHTLINE_ASSIGN(const FileContent file, read_file_content(path));
  if (xxh3(file.bytes()) != scan.content_xxh3) return changed(path);
  return with_remedy(parse_point_cloud(file.bytes(), path, recording.columns));
}

Result<PointCloudFile> read_checked(const Recording& recording, const ScanInFile& scan) {
  return recording.container ? read_contained(recording, scan) : read_alone(recording, scan);
}

class RecordedScanStore : public ScanStore {
 public:
  explicit RecordedScanStore(const Recording& recording)
      : scans_(recording.scans.begin(), recording.scans.end()),
        step_ns_(usual_step_ns(recording.scans)) {
    opened_.source = recording.source;
    opened_.container = recording.container;
    opened_.columns = recording.columns;
    opened_.digest = recording.digest;
  }

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    const ScanInFile& scan = scans_[index];
    SIGHTLINE_ASSIGN(PointCloudFile cloud, read_checked(opened_, scan));
    settle_point_times(scan.stamp_ns, step_ns_, cloud);
    return Scan{scan.stamp_ns, std::move(cloud.points_m), std::move(cloud.time_offset_ns)};
  }

  // A scan in a file of its own is the same in another recording. How one in a file of many is read
  // may depend on what else that holds.
  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    const ScanInFile& scan = scans_[index];
    ByteWriter writer;
    if (opened_.container) {
      writer.put<std::uint64_t>(scan.index);
      return derived_digest("scan of a file", opened_.digest, writer.bytes());
    }
    writer.put(scan.stamp_ns);
    writer.put(step_ns_);
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
  std::int64_t step_ns_ = 0;
  Recording opened_;  // without its scans, whose poses would be the most of it
};

// The scans' files, or names of the parts of the one file that holds them.
Result<std::vector<std::filesystem::path>> list_scans(const RecordingOptions& options,
                                                      Recording& recording) {
  if (!is_scan_container(options.scans)) {
    if (options.topic.empty()) return list_scan_files(options.scans);
    return Error{ErrorCode::kBadValue, "topic is only for bags, found " + options.scans};
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
                 "columns is only for .bin scans, which have no header; found " +
                     recording.scans.front().name};
  }
  SIGHTLINE_ASSIGN(recording.columns, parse_float_columns(options.columns));
  return {};
}

}  // namespace

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
  SIGHTLINE_TRY(take_inertial_unit(options, recording));
  SIGHTLINE_TRY(take_wheel_speeds(options, recording));
  SIGHTLINE_TRY(take_digests(recording, threads, memory));
  recording.digest = digest_of(recording);
  return recording;
}

Result<PointCloudFile> read_recorded_scan(const Recording& recording, std::size_t index) {
  SIGHTLINE_CHECK(index < recording.scans.size());
  return read_checked(recording, recording.scans[index]);
}

Result<PointCloudFile> read_listed_scan(const Recording& recording, std::size_t index) {
  SIGHTLINE_CHECK(index < recording.scans.size());
  const RecordedScan& scan = recording.scans[index];
  if (!recording.container) {
    return with_remedy(read_point_cloud(recording.file_of(scan), recording.columns));
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, recording.container->read(scan.index));
  return recording.container->parse(bytes, scan.index);
}

std::shared_ptr<const ScanStore> recorded_scan_store(const Recording& recording) {
  auto store = std::make_shared<const RecordedScanStore>(recording);
  return recording.memory ? ScanMemory::before(std::move(store), recording.memory) : store;
}

}  // namespace sightline
