#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "formats/base/files/regular_file.h"
#include "formats/base/units.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/text/dataset_poses.h"
#include "formats/foreign/text/geodetic_track.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/foreign/text/stamp.h"

namespace sightline {
namespace {

using Files = std::vector<std::filesystem::path>;

// The row of each scan in a table of `rows`, at least as many as files; warns where not all are
// used.
std::vector<std::size_t> choose_rows(const Files& files, std::size_t rows, const std::string& table,
                                     Recording& recording) {
  std::vector<std::size_t> row_of_scan;
  bool names_are_rows = rows > files.size();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::optional<std::int64_t> number = scan_number(files[i]);
    names_are_rows = names_are_rows && number && *number < static_cast<std::int64_t>(rows) &&
                     (i == 0 || *number > *scan_number(files[i - 1]));
    row_of_scan.push_back(i);
  }
  if (names_are_rows) {
    for (std::size_t i = 0; i < files.size(); ++i) {
      row_of_scan[i] = static_cast<std::size_t>(*scan_number(files[i]));
    }
  }
  if (rows > files.size()) {
    recording.warnings.push_back(
        concat(table, " has ", rows, " rows for ", files.size(),
               " scans: ", files.front().filename().string(), " takes row ", row_of_scan.front(),
               " (from 0), ", files.back().filename().string(), " row ", row_of_scan.back(),
               (names_are_rows ? ", by the number in its name" : ", by its position")));
  }
  return row_of_scan;
}

using Stamps = std::vector<std::optional<std::int64_t>>;
using Poses = std::vector<std::optional<PoseRow>>;

void warn_of_unit(const std::string& path, const std::string& unit, Recording& recording) {
  if (unit.empty()) return;
  recording.warnings.push_back(
      concat(path, ": in seconds its times would be at least 20 s apart; they are read as ", unit,
             ". Write seconds with a decimal point"));
}

Result<Stamps> stamps_from_file(const std::string& path, const Files& files, Recording& recording) {
  SIGHTLINE_ASSIGN(std::vector<std::int64_t> rows, read_stamps(path));
  if (rows.size() < files.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat("found ", rows.size(), " times for ", files.size(), " scans"), path};
  }
  warn_of_unit(path, take_finer_unit(rows), recording);
  Stamps stamps;
  for (const std::size_t row : choose_rows(files, rows.size(), path, recording)) {
    stamps.emplace_back(rows[row]);
  }
  return stamps;
}

// Those of the file that holds the scans, or their names where all of them are times; else empty.
Stamps stamps_of_themselves(const Recording& recording, const Files& files) {
  Stamps stamps;
  if (recording.container) {
    for (const ContainedScan& scan : recording.container->scans()) {
      stamps.emplace_back(scan.stamp_ns);
    }
    return stamps;
  }
  for (const std::filesystem::path& file : files) {
    stamps.push_back(scan_stamp_ns(file));
    if (!stamps.back()) return {};
  }
  return stamps;
}

Error fewer_poses(const std::string& path, const std::string& what) {
  return {ErrorCode::kFewerPosesThanScans, what, path};
}

Result<Poses> poses_by_row(const std::string& path, const Files& files,
                           const std::vector<PoseRow>& rows, Recording& recording) {
  if (rows.size() < files.size()) {
    return fewer_poses(
        path,
        concat("found ", rows.size(), " poses for ", files.size(),
               " scans; supply one for each scan, or name no poses so that they are estimated"));
  }
  Poses poses;
  for (const std::size_t row : choose_rows(files, rows.size(), path, recording)) {
    poses.push_back(rows[row]);
  }
  return poses;
}

Result<Poses> poses_by_id(const std::string& path, const Files& files,
                          const std::vector<PoseRow>& rows) {
  std::map<std::optional<std::int64_t>, const PoseRow*> row_of;  // the first of each id
  for (const PoseRow& row : rows) row_of.try_emplace(row.id, &row);
  Poses poses;
  for (const std::filesystem::path& file : files) {
    const std::optional<std::int64_t> number = scan_number(file);
    const auto row = number ? row_of.find(number) : row_of.end();
    if (row == row_of.end()) {
      return fewer_poses(path,
                         concat("no pose has the number of ", file.filename().string(), " as id"));
    }
    poses.push_back(*row->second);
  }
  return poses;
}

// Where the poses lie in time, and how clocks of two kinds come to be that far apart.
std::string span_of(const std::vector<PoseRow>& rows, std::int64_t stamp_ns) {
  constexpr std::int64_t kHour_s = 3600;
  constexpr std::int64_t kLeastOff_s = 600;
  const std::int64_t first_ns = *rows.front().stamp_ns;
  const std::int64_t last_ns = *rows.back().stamp_ns;
  std::string text =
      concat("; they run from ", format_stamp(first_ns), " to ", format_stamp(last_ns));
  if (stamp_ns >= first_ns && stamp_ns <= last_ns) return text + ", with a gap of over 1.5 s there";
  const std::int64_t off_s = (stamp_ns - first_ns) / kSecond_ns;
  const std::int64_t hours = (off_s + (off_s < 0 ? -kHour_s : kHour_s) / 2) / kHour_s;
  if (std::abs(off_s) < kLeastOff_s) return text;
  text += "; the clocks of scans and poses differ";
  const bool is_zone =
      hours != 0 && std::abs(hours) <= 14 && std::abs(off_s - hours * kHour_s) < kLeastOff_s;
  if (is_zone) text += concat(" by ", std::abs(hours), " h, which is a time zone");
  return text + ": write both in the same one";
}

Result<Poses> poses_by_time(const std::string& path, const Files& files,
                            const std::vector<PoseRow>& rows, const Stamps& stamps_ns,
                            Recording& recording) {
  recording.pose_rows = rows;
  Poses poses;
  PosedScans posed;
  for (std::size_t i = 0; i < files.size(); ++i) {
    poses.push_back(pose_at(rows, *stamps_ns[i]));
    posed.add(poses.back().has_value());
  }
  if (posed.may_be_used()) return poses;
  const std::size_t missing = posed.first_missing();
  return fewer_poses(
      path, concat("no poses before and after time ", format_stamp(*stamps_ns[missing]), " s of ",
                   files[missing].filename().string(), span_of(rows, *stamps_ns[missing])));
}

// A topic begins later than the scans and ends earlier, or has gaps: those scans have no pose.
Result<Poses> poses_from_bag(const RecordingOptions& options, const Stamps& stamps_ns,
                             Recording& recording) {
  // Transforms tell where the sensor itself was.
  const bool are_of_sensor = options.poses_of == PosesOf::kSensor && recording.container;
  const std::string frame = are_of_sensor ? recording.container->frame() : "";
  SIGHTLINE_ASSIGN(const std::optional<GeodeticTrack> track,
                   read_bag_fixes(options.poses, options.poses_topic));
  std::vector<PoseRow> rows;
  if (track) {
    SIGHTLINE_ASSIGN(TrackInWorld found, in_world(*track, options.world, options.poses));
    recording.warnings.insert(recording.warnings.end(), found.warnings.begin(),
                              found.warnings.end());
    rows = std::move(found.rows);
  } else {
    SIGHTLINE_ASSIGN(
        rows, read_bag_poses(options.poses, options.poses_topic, frame, &recording.world_frame));
  }
  recording.pose_rows = rows;
  if (stamps_ns.empty()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "a bag's poses are assigned by time, but the scans have no times. Name a file of "
                 "times with `stamps`",
                 options.poses};
  }
  Poses poses;
  std::size_t missing = 0;
  for (const std::optional<std::int64_t>& stamp_ns : stamps_ns) {
    poses.push_back(pose_at(rows, *stamp_ns));
    missing += poses.back() ? 0 : 1;
  }
  if (missing == stamps_ns.size()) {
    return fewer_poses(options.poses,
                       concat("none of the ", rows.size(), " poses is at the time of a scan"));
  }
  return poses;
}

// Times of all rows or of none, in a finer unit than seconds where they are of one.
void take_unit_of_times(const std::string& path, std::vector<PoseRow>& rows, Recording& recording) {
  std::vector<std::int64_t> stamps_ns;
  for (const PoseRow& row : rows) {
    if (row.stamp_ns) stamps_ns.push_back(*row.stamp_ns);
  }
  if (stamps_ns.empty()) return;
  warn_of_unit(path, take_finer_unit(stamps_ns), recording);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].stamp_ns = stamps_ns[i];
}

// In degrees: as many as there are scans belong to them one by one (KITTI's, synced).
Result<Poses> poses_from_track(const RecordingOptions& options, const Files& files,
                               const Stamps& stamps_ns, Recording& recording) {
  SIGHTLINE_ASSIGN(const GeodeticTrack track, read_geodetic_track(options.poses));
  SIGHTLINE_ASSIGN(const TrackInWorld found, in_world(track, options.world, options.poses));
  recording.warnings.insert(recording.warnings.end(), found.warnings.begin(), found.warnings.end());
  std::vector<PoseRow> rows = found.rows;
  const bool is_timed = rows.front().stamp_ns && !stamps_ns.empty();
  if (!is_timed || rows.size() == files.size()) {
    return poses_by_row(options.poses, files, rows, recording);
  }
  take_unit_of_times(options.poses, rows, recording);
  return poses_by_time(options.poses, files, rows, stamps_ns, recording);
}

// nuScenes' table holds those of all its drives.
Result<Poses> poses_from_table(const RecordingOptions& options, const Files& files,
                               const Stamps& stamps_ns, Recording& recording) {
  SIGHTLINE_ASSIGN(const std::vector<PoseRow> rows, read_nuscenes_poses(options.poses));
  if (stamps_ns.empty()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "these poses are assigned by time, but the scans' names contain none. Name a file "
                 "of times with `stamps`",
                 options.poses};
  }
  return poses_by_time(options.poses, files, rows, stamps_ns, recording);
}

// Poses of another part of the vehicle become those of the sensor.
Result<void> take_calibration(const RecordingOptions& options, Poses& poses, Recording& recording) {
  if (options.calibration.empty()) return {};
  if (options.poses_of != PosesOf::kSensor) {
    return Error{ErrorCode::kBadValue,
                 "calibration converts the poses to the sensor: write poses_of: sensor",
                 options.calibration};
  }
  SIGHTLINE_ASSIGN(const KittiCalibration calibration, read_kitti_calibration(options.calibration));
  for (std::optional<PoseRow>& pose : poses) {
    if (pose) pose->T_world_vehicle = lidar_pose(calibration, pose->T_world_vehicle);
  }
  for (PoseRow& row : recording.pose_rows) {
    row.T_world_vehicle = lidar_pose(calibration, row.T_world_vehicle);
  }
  return {};
}

void warn_of_repeated(const std::string& path, const std::vector<PoseRow>& rows,
                      Recording& recording) {
  std::size_t repeated = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    repeated += rows[i].stamp_ns && rows[i].stamp_ns == rows[i - 1].stamp_ns ? 1 : 0;
  }
  if (repeated == 0) return;
  recording.warnings.push_back(concat(path, ": ", repeated, " of ", rows.size(),
                                      " rows have the time of the row before them"));
}

Result<Poses> poses_from_file(const RecordingOptions& options, const Files& files,
                              const Stamps& stamps_ns, Recording& recording) {
  SIGHTLINE_ASSIGN(std::vector<PoseRow> rows, read_poses(options.poses, options.pose_format));
  warn_of_repeated(options.poses, rows, recording);
  take_unit_of_times(options.poses, rows, recording);
  recording.has_quaternions = !rows.empty() && rows.front().stamp_ns.has_value();
  if (!rows.empty() && rows.front().id) return poses_by_id(options.poses, files, rows);
  if (!rows.empty() && rows.front().stamp_ns && !stamps_ns.empty()) {
    return poses_by_time(options.poses, files, rows, stamps_ns, recording);
  }
  return poses_by_row(options.poses, files, rows, recording);
}

// One for each scan; none at all where no poses are named.
Result<Poses> poses_of_scans(const RecordingOptions& options, const Files& files,
                             const Stamps& stamps_ns, Recording& recording) {
  if (options.poses.empty()) return Poses(files.size());
  if (is_ros_bag(options.poses)) return poses_from_bag(options, stamps_ns, recording);
  std::error_code failure;
  const bool is_folder = std::filesystem::is_directory(options.poses, failure);
  if (!is_folder) {
    SIGHTLINE_TRY(open_regular_file(options.poses));  // a pipe would wait for its writer
  }
  if (!is_folder && is_nuscenes_poses(options.poses)) {
    return poses_from_table(options, files, stamps_ns, recording);
  }
  if (is_geodetic(options.poses)) return poses_from_track(options, files, stamps_ns, recording);
  return poses_from_file(options, files, stamps_ns, recording);
}

std::string name_of(const Recording& recording, const Files& files, std::size_t index) {
  const std::filesystem::path& file = files[index];
  const std::string name = (file.has_filename() ? file : file.parent_path()).filename().string();
  return recording.container ? concat(name, "#", index) : name;
}

}  // namespace

Result<void> describe_scans(const RecordingOptions& options,
                            const std::vector<std::filesystem::path>& files, Recording& recording) {
  Stamps stamps_ns = stamps_of_themselves(recording, files);
  if (!options.stamps.empty()) {
    SIGHTLINE_ASSIGN(Stamps given, stamps_from_file(options.stamps, files, recording));
    stamps_ns = std::move(given);
  }
  SIGHTLINE_ASSIGN(Poses poses, poses_of_scans(options, files, stamps_ns, recording));
  SIGHTLINE_TRY(take_calibration(options, poses, recording));
  if (!(options.rate_hz > 0.0)) return Error{ErrorCode::kBadValue, "rate_hz must be above 0"};
  recording.scans.resize(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    RecordedScan& scan = recording.scans[i];
    scan.name = name_of(recording, files, i);
    const auto index_ns =
        static_cast<std::int64_t>(std::llround(static_cast<double>(i) * 1e9 / options.rate_hz));
    scan.stamp_ns = index_ns;
    if (const std::optional<PoseRow>& pose = poses[i]) {
      scan.T_world_vehicle = pose->T_world_vehicle;
      scan.stamp_ns = pose->stamp_ns.value_or(index_ns);
    }
    if (!stamps_ns.empty()) scan.stamp_ns = *stamps_ns[i];
    scan.index = static_cast<std::uint32_t>(i);
  }
  leave_out_unposed(options.poses, recording);
  leave_out_untimely(recording);
  return {};
}

}  // namespace sightline
