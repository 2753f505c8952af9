#include "compiler/init/find_scans.h"

#include <linux/magic.h>
#include <sys/vfs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <vector>

#include "formats/base/files/regular_file.h"
#include "formats/base/units.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/ros_messages.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"
#include "passes/ingest/pose_reading.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 4;

bool is_hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

bool path_less(const fs::path& a, const fs::path& b) {
  return natural_less(a.string(), b.string());
}

struct Listing {
  std::vector<fs::path> files;
  std::vector<fs::path> folders;
};

// What the kernel shows as files (/proc, /sys) is no recording, and by its links everything is
// below it.
bool is_of_kernel(const fs::path& folder) {
  struct statfs system {};
  if (::statfs(folder.c_str(), &system) != 0) return false;
  return system.f_type == PROC_SUPER_MAGIC || system.f_type == SYSFS_MAGIC;
}

Result<Listing> list_folder(const fs::path& folder) {
  if (is_of_kernel(folder)) return Listing();
  std::error_code failure;
  fs::directory_iterator entry(folder, failure);
  Listing listing;
  while (!failure && entry != fs::directory_iterator()) {
    std::error_code ignored;
    if (!is_hidden(entry->path())) {
      (entry->is_directory(ignored) ? listing.folders : listing.files).push_back(entry->path());
    }
    entry.increment(failure);
  }
  if (failure) {
    return Error{ErrorCode::kCannotOpen, "cannot list the folder: " + failure.message(),
                 folder.string()};
  }
  std::ranges::sort(listing.files, path_less);
  std::ranges::sort(listing.folders, path_less);
  return listing;
}

bool looks_like_text(const fs::path& file) {
  constexpr std::array<std::string_view, 6> kEndings = {".txt",   ".tum",   ".csv",
                                                        ".poses", ".kitti", ".dat"};
  return std::ranges::find(kEndings, lower_extension(file)) != kEndings.end();
}

// Words of a line, and how many of them are numbers; none of a comment.
struct Columns {
  std::size_t count = 0;
  std::size_t numbers = 0;
};

Columns columns_of(std::string line) {
  std::ranges::replace(line, ',', ' ');
  std::istringstream words(line);
  Columns columns;
  for (std::string word; words >> word; ++columns.count) {
    if (columns.count == 0 && word.starts_with('#')) break;
    std::istringstream number(word);
    double value = 0.0;
    columns.numbers += number >> value && number.eof() ? 1U : 0U;
  }
  return columns;
}

// Columns of the first line that is no comment, where all of them are numbers; else 0, also where
// that line does not end near the beginning. A line of names may stand before it.
std::size_t columns_of_numbers(const fs::path& file) {
  constexpr std::size_t kMostBytes = 64 * 1024;
  const Result<std::string> beginning = read_beginning(file.string(), kMostBytes);
  if (!beginning) return 0;
  const bool is_cut = beginning->size() == kMostBytes;
  std::istringstream stream(is_cut ? beginning->substr(0, beginning->rfind('\n') + 1) : *beginning);
  bool is_first = true;
  for (std::string line; std::getline(stream, line);) {
    const Columns columns =
        columns_of(std::string(is_first ? without_byte_order_mark(line) : line));
    if (columns.count == 0) continue;
    const bool is_head = is_first && columns.numbers == 0;
    is_first = false;
    if (is_head) continue;
    return columns.numbers == columns.count ? columns.count : 0;
  }
  return 0;
}

void sort_out(const fs::path& file, FoundScans& found) {
  if (!looks_like_text(file)) return;
  const std::size_t columns = columns_of_numbers(file);
  if (columns == 1) found.stamp_files.push_back(file);
  if (columns == 8 || columns == 9 || columns == 12) found.pose_files.push_back(file);
}

bool is_named_after(const fs::path& file, const fs::path& scans) {
  return std::ranges::find(scans.begin(), scans.end(), file.stem()) != scans.end() ||
         file.stem() == scans.stem();
}

// From beside the scans up to the folder that was named.
void find_companions(const fs::path& top, FoundScans& found) {
  std::error_code ignored;
  fs::path folder =
      fs::is_directory(found.scans, ignored) ? found.scans : found.scans.parent_path();
  for (int up = 0; up <= kDeepest; ++up) {
    const Result<Listing> listing = list_folder(folder);
    if (listing) {
      for (const fs::path& file : listing->files) sort_out(file, found);
    }
    const Result<Listing> poses = list_folder(folder / "poses");
    if (poses) {
      for (const fs::path& file : poses->files) {
        if (is_named_after(file, found.scans)) sort_out(file, found);
      }
    }
    if (folder == top) return;
    folder = folder.parent_path();
  }
}

void look_into(const fs::path& folder, int depth, ScanSearch& search) {
  if (is_scan_container(folder)) {  // a recording of several files
    search.found.push_back({folder, {}, {}});
    return;
  }
  const Result<Listing> listing = list_folder(folder);
  if (!listing) {
    search.passed_over.push_back({folder, listing.error().message});
    return;
  }
  for (const fs::path& file : listing->files) {
    if (is_scan_container(file)) search.found.push_back({file, {}, {}});
  }
  const Result<std::vector<fs::path>> scans = list_scan_files(folder);
  if (scans && scans->size() >= 2) {
    search.found.push_back({folder, {}, {}});
  } else if (scans) {
    search.passed_over.push_back({folder, "only one scan, expected a drive"});
  } else if (scans.error().code != ErrorCode::kEmptyDirectory) {
    const bool is_container =
        std::ranges::any_of(listing->files, [](const fs::path& f) { return is_scan_container(f); });
    if (!is_container) search.passed_over.push_back({folder, scans.error().message});
  }
  if (depth == kDeepest) return;
  for (const fs::path& inner : listing->folders) look_into(inner, depth + 1, search);
}

// A file that is no recording of many scans: how it is to be converted, or what is wanted.
Result<void> refuse_other_file(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return {};
  constexpr std::array<std::string_view, 13> kForeign = {".osf", ".lvx", ".lvx2", ".laz", ".e57",
                                                         ".zip", ".7z",  ".tar",  ".tgz", ".gz",
                                                         ".xz",  ".zst", ".xyz"};
  if (std::ranges::find(kForeign, lower_extension(file)) != kForeign.end()) {
    const Result<PointCloudFile> scan = read_point_cloud(file);
    if (!scan && scan.error().code == ErrorCode::kUnsupportedFormat) return scan.error();
  }
  return Error{
      ErrorCode::kCannotOpen,
      "this file does not begin like a ROS bag (.bag, .db3, .mcap) or a capture (.pcap, .pcapng); "
      "expected one of these or a folder of scans (for poses, the folder with their scans)",
      file.string()};
}

// T_vehicle_lidar as the configuration writes it.
void set_mounting(const Pose& T_vehicle_lidar, RecordingOptions& options) {
  const auto to_micro = [](double value) { return std::round(1e6 * value) / 1e6; };
  const Eigen::Matrix3d R = T_vehicle_lidar.linear();
  options.lidar_x_m = to_micro(T_vehicle_lidar.translation().x());
  options.lidar_y_m = to_micro(T_vehicle_lidar.translation().y());
  options.lidar_z_m = to_micro(T_vehicle_lidar.translation().z());
  options.lidar_roll_deg = to_micro(kDegPerRad * std::atan2(R(2, 1), R(2, 2)));
  options.lidar_pitch_deg = to_micro(-kDegPerRad * std::asin(std::clamp(R(2, 0), -1.0, 1.0)));
  options.lidar_yaw_deg = to_micro(kDegPerRad * std::atan2(R(1, 0), R(0, 0)));
}

// Of the bag that holds the scans.
std::vector<FoundPoses> pose_topics(const fs::path& bag, const Recording& recording) {
  std::vector<FoundPoses> sources;
  const Result<std::vector<BagTopic>> topics = list_bag_topics(bag);
  if (!topics) return sources;
  const Result<std::optional<Pose>> mounting = bag_mounting(bag, recording.container->frame());
  for (const BagTopic& topic : *topics) {
    const bool are_transforms = is_transforms_message(topic.type);
    if (are_transforms && topic.name.ends_with("tf_static")) continue;
    if (!are_transforms && !is_pose_message(topic.type)) continue;
    sources.push_back({bag.string(), topic.name, are_transforms, {}});
    if (are_transforms || !mounting || !*mounting) continue;
    sources.push_back(sources.back());
    sources.back().T_vehicle_lidar = *mounting;
  }
  return sources;
}

Eigen::Vector3d position_m(const Recording& recording, std::size_t scan) {
  return recording.scans[scan].T_world_vehicle->translation();
}

struct Clouds {
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
  Pose T_first_second;  // of the sensor by its poses and its mounting
};

double share_at_yaw(const Clouds& clouds, double yaw_deg) {
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.rotate(
      Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()));
  const Pose T = T_vehicle_lidar.inverse() * clouds.T_first_second * T_vehicle_lidar;
  return share_that_falls_on(clouds.first, clouds.second, T);
}

Result<std::vector<Clouds>> read_pairs(const Recording& recording, double height_m) {
  std::vector<Clouds> read;
  const Pose& T_vehicle_lidar = recording.sensor.T_vehicle_lidar;
  for (const ScanPair& pair : choose_pairs(recording)) {
    const Result<PointCloudFile> first = read_listed_scan(recording, pair.first);
    const Result<PointCloudFile> second = read_listed_scan(recording, pair.second);
    if (!first && !is_without_returns(first.error())) return first.error();
    if (!second && !is_without_returns(second.error())) return second.error();
    if (!first || !second) continue;
    read.push_back(
        {upright_returns(*first, height_m), upright_returns(*second, height_m),
         T_vehicle_lidar.inverse() * recording.scans[pair.first].T_world_vehicle->inverse() *
             *recording.scans[pair.second].T_world_vehicle * T_vehicle_lidar});
  }
  return read;
}

void describe_way(const Recording& recording, PoseOverlap& overlap) {
  double climbed_m = 0.0;
  std::size_t upright = 0;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    // Within 45 degrees.
    upright += recording.scans[i].T_world_vehicle->linear()(2, 2) > 0.7 ? 1 : 0;
    if (i == 0) continue;
    const Eigen::Vector3d step_m = position_m(recording, i) - position_m(recording, i - 1);
    overlap.length_m += step_m.norm();
    climbed_m += std::abs(step_m.z());
  }
  overlap.is_z_up = 2 * upright > recording.scans.size() && 2.0 * climbed_m < overlap.length_m;
}

}  // namespace

Result<ScanSearch> find_scans(const fs::path& folder) {
  std::error_code failure;
  if (!fs::exists(folder, failure)) {
    return Error{ErrorCode::kFileNotFound, "there is no such folder", folder.string()};
  }
  const fs::path absolute = (fs::current_path() / folder).lexically_normal();
  const fs::path start = absolute.has_filename() ? absolute : absolute.parent_path();
  ScanSearch search;
  if (is_scan_container(start)) {
    search.found.push_back({start, {}, {}});
  } else {
    SIGHTLINE_TRY(refuse_other_file(start));
    SIGHTLINE_TRY(list_folder(start));
    look_into(start, 0, search);
  }
  std::ranges::sort(search.found, path_less, &FoundScans::scans);
  for (FoundScans& found : search.found) {
    find_companions(fs::is_directory(start, failure) ? start : start.parent_path(), found);
  }
  return search;
}

std::string FoundPoses::words() const {
  if (topic.empty()) return fs::path(file).filename().string();
  return topic + (T_vehicle_lidar ? " with the mounting from the bag's transforms" : "");
}

std::vector<FoundPoses> pose_sources(const FoundScans& found, const Recording& listed) {
  std::vector<FoundPoses> sources;
  if (is_ros_bag(found.scans)) sources = pose_topics(found.scans, listed);
  for (const fs::path& file : found.pose_files) sources.push_back({file.string(), "", false, {}});
  return sources;
}

RecordingOptions with_poses(const FoundPoses& source, RecordingOptions options) {
  options.poses = source.file;
  options.poses_topic = source.topic;
  if (source.are_transforms) options.poses_of = PosesOf::kSensor;
  if (source.T_vehicle_lidar) set_mounting(*source.T_vehicle_lidar, options);
  return options;
}

Result<PoseOverlap> measure_overlap(const Recording& recording, double height_m) {
  // Another yaw of the sensor is a strong claim.
  constexpr double kFarBetter = 1.5;
  PoseOverlap overlap;
  for (const RecordedScan& scan : recording.scans) {
    if (!scan.T_world_vehicle) return overlap;
  }
  describe_way(recording, overlap);
  SIGHTLINE_ASSIGN(const std::vector<Clouds> pairs, read_pairs(recording, height_m));
  overlap.pairs = pairs.size();
  if (pairs.empty()) return overlap;
  for (const double yaw_deg : {0.0, 90.0, 180.0, -90.0}) {
    double sum = 0.0;
    for (const Clouds& clouds : pairs) sum += share_at_yaw(clouds, yaw_deg);
    const double share = sum / static_cast<double>(pairs.size());
    if (yaw_deg != 0.0 && share < kFarBetter * overlap.share) continue;
    overlap.share = share;
    overlap.yaw_deg = yaw_deg;
  }
  return overlap;
}

}  // namespace sightline
