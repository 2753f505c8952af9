#include "compiler/init/look_at_drive.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

#include "compiler/init/find_scans.h"
#include "formats/drive/sensor_profile.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/scan_messages.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"
#include "passes/ingest/check_frame.h"
#include "passes/ingest/guess_sensor.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::string rounded(double value, double step) {
  return format_double(std::round(value / step) * step);
}

Error no_lidar(const fs::path& file, const std::string& what) {
  return {ErrorCode::kUnsupportedFormat,
          what + ", so these are not LiDAR scans in the sensor frame", file.string()};
}

Result<std::vector<PointCloudFile>> read_samples(const Recording& recording) {
  std::vector<PointCloudFile> samples;
  for (const std::size_t index : sample_scans(recording.scans.size())) {
    Result<PointCloudFile> sample = read_listed_scan(recording, index);
    if (sample) {
      samples.push_back(*std::move(sample));
    } else if (!is_without_returns(sample.error())) {
      return sample.error();
    }
  }
  return samples;
}

Result<void> check_reach(const fs::path& scans, const std::vector<PointCloudFile>& samples) {
  constexpr double kNear_m = 0.5;
  constexpr double kFar_m = 2000.0;
  std::vector<double> away_m;
  for (const PointCloudFile& sample : samples) {
    for (const Eigen::Vector3d& point_m : sample.points_m) away_m.push_back(point_m.norm());
  }
  if (away_m.empty()) return no_lidar(scans, "no points");
  const auto middle = away_m.begin() + static_cast<std::ptrdiff_t>(away_m.size() / 2);
  std::ranges::nth_element(away_m, middle);
  const std::string found = concat("half of the points lie within ", rounded(*middle, 0.01), " m");
  if (*middle < kNear_m || *middle > kFar_m) return no_lidar(scans, found);
  return {};
}

// Of scans without a header.
void add_columns(const std::vector<PointCloudFile>& samples, FoundDrive& drive) {
  const std::size_t count = samples.front().float_count;
  const bool is_one_count = std::ranges::all_of(
      samples, [&](const PointCloudFile& sample) { return sample.float_count == count; });
  if (count == 0 || !is_one_count) return;
  drive.keys.push_back(
      {"columns", to_text(columns_of_count(count)),
       concat(count, " floats per point fit the file size; these files have no header")});
}

void add_sensor(const SensorGuess& guess, const Recording& recording, FoundDrive& drive) {
  const fs::path file = recording.container ? recording.container->sensor_file() : fs::path();
  const bool is_named = guess.reason.starts_with("named by");
  if (!file.empty() && !is_named) {
    drive.keys.push_back(
        {"sensor", file.string(), "metadata of the sensor that sent these packets"});
  } else if (!guess.profile.empty()) {
    drive.keys.push_back({"sensor", guess.profile, guess.reason});
  } else {
    drive.keys.push_back({"rings", std::to_string(guess.rings), guess.reason});
    drive.keys.push_back({"lowest_beam_deg", format_double(guess.lowest_beam_deg), ""});
    drive.keys.push_back({"highest_beam_deg", format_double(guess.highest_beam_deg), ""});
  }
  if (guess.azimuth_view_deg) {
    drive.keys.push_back({"azimuth_view_deg", format_double(*guess.azimuth_view_deg),
                          "the part of a turn that contains returns"});
  }
  if (guess.height_m) {
    drive.keys.push_back({"height_m", format_double(*guess.height_m),
                          "the height above the ground by the returns below the sensor"});
  }
}

// Letters and digits of a text, small.
std::string letters_of(const std::string& text) {
  std::string letters;
  for (const unsigned char c : text) {
    if (std::isalnum(c) != 0) letters += static_cast<char>(std::tolower(c));
  }
  return letters;
}

// The profile whose name is the longest in the last folders of a path or in a topic, if its beams
// fit these scans: several sensors have the same beams. Empty: there is none.
std::string named_profile(const fs::path& scans, const std::string& topic,
                          const std::vector<PointCloudFile>& samples) {
  const fs::path folder = scans.parent_path();
  const std::string words =
      letters_of(concat(folder.filename().string(), " ", scans.filename().string(), " ", topic));
  const std::vector<double> elevations = elevations_deg(samples);
  std::string best;
  for (const std::string& name : sensor_profile_names()) {
    if (words.find(letters_of(name)) == std::string::npos || name.size() <= best.size()) continue;
    const SensorProfile profile = *sensor_profile(name);
    if (fit_beams(elevations, profile.beam_elevations_deg).is_crisp()) best = name;
  }
  return best;
}

// A name comes before what fits as well.
void prefer_named(const std::string& sensor, const FoundScans& found, const std::string& topic,
                  const std::vector<PointCloudFile>& samples, SensorGuess& guess) {
  if (!sensor.empty()) {
    guess.reason =
        guess.profile.empty() || guess.profile == sensor
            ? "named by --sensor"
            : concat("named by --sensor; the scans look like ", guess.profile, ": ", guess.reason);
    guess.profile = sensor;
    return;
  }
  const std::string named = named_profile(found.scans, topic, samples);
  if (named.empty() || named == guess.profile) return;
  guess.reason = concat("the path or the topic names it, and its beams fit as well as those of ",
                        guess.profile);
  guess.profile = named;
}

struct Candidate {
  FoundPoses source;
  RecordingOptions options;
  Recording recording;
  PoseOverlap overlap;
};

// Empty: the poses do.
std::string objection(const Candidate& candidate) {
  constexpr double kLeast = 0.2;
  const PoseOverlap& overlap = candidate.overlap;
  const bool is_mounted = candidate.source.are_transforms || candidate.source.T_vehicle_lidar;
  if (is_mounted && overlap.yaw_deg != 0.0)
    return "scans overlap only when they are rotated further";
  if (!overlap.is_z_up) return "its poses are not level with z up; they may be those of a camera";
  if (overlap.pairs > 0 && overlap.share < kLeast) {
    return concat("only ", whole_percent(overlap.share),
                  " of the returns from upright surfaces overlap other scans");
  }
  return "";
}

// A file that says why it has these poses ("poses_true.tum") is no better than "poses.tum" unless
// scans say so. A mounting that is given is better than none.
bool is_better(const Candidate& a, const Candidate& b) {
  constexpr double kClear = 0.05;
  const bool are_of_one = a.source.topic == b.source.topic && !a.source.topic.empty();
  if (are_of_one && a.source.T_vehicle_lidar && a.overlap.yaw_deg == 0.0 &&
      a.overlap.share > b.overlap.share - kClear) {
    return true;
  }
  if (std::abs(a.overlap.share - b.overlap.share) > kClear) {
    return a.overlap.share > b.overlap.share;
  }
  return a.source.words().size() < b.source.words().size();
}

// The best of those that fit; `remarks` collects the reasons against the others. Errors: those of
// check_frame.
Result<std::optional<Candidate>> choose_poses(const FoundScans& found, const Recording& listed,
                                              const RecordingOptions& options, double height_m,
                                              std::string& remarks) {
  std::optional<Candidate> best;
  const auto remark = [&](const Candidate& other, const std::string& what) {
    remarks += concat((remarks.empty() ? "" : "; "), other.source.words(), ": ", what);
  };
  for (const FoundPoses& source : pose_sources(found, listed)) {
    Candidate candidate{source, with_poses(source, options), {}, {}};
    Result<Recording> recording = list_recording(candidate.options);
    if (!recording) {
      remark(candidate, recording.error().message);
      continue;
    }
    candidate.recording = std::move(*recording);
    SIGHTLINE_TRY(check_frame(candidate.recording));
    const Result<PoseOverlap> overlap = measure_overlap(candidate.recording, height_m);
    if (overlap) candidate.overlap = *overlap;
    const std::string fault = overlap ? objection(candidate) : overlap.error().message;
    if (!fault.empty()) {
      remark(candidate, fault);
      continue;
    }
    if (best && is_better(candidate, *best)) std::swap(candidate, *best);
    if (best) remark(candidate, "fits as well");
    if (!best) best = std::move(candidate);
  }
  return best;
}

void add_mounting(const RecordingOptions& options, FoundDrive& drive) {
  drive.keys.push_back(
      {"poses_of", "vehicle", "the mounting of the sensor is in the bag's transforms"});
  const std::pair<const char*, double> values[] = {{"lidar_x_m", options.lidar_x_m},
                                                   {"lidar_y_m", options.lidar_y_m},
                                                   {"lidar_z_m", options.lidar_z_m},
                                                   {"lidar_roll_deg", options.lidar_roll_deg},
                                                   {"lidar_pitch_deg", options.lidar_pitch_deg},
                                                   {"lidar_yaw_deg", options.lidar_yaw_deg}};
  for (const auto& [key, value] : values) {
    if (value != 0.0) drive.keys.push_back({key, format_double(value), ""});
  }
}

// Whose poses they are.
void add_owner(const Candidate& chosen, FoundDrive& drive) {
  if (chosen.source.are_transforms) {
    drive.keys.push_back({"poses_of", "sensor", "the transforms are poses of the sensor"});
  } else if (chosen.source.T_vehicle_lidar) {
    add_mounting(chosen.options, drive);
  } else if (chosen.overlap.yaw_deg == 0.0) {
    drive.keys.push_back({"poses_of", "sensor",
                          "scans overlap without rotation; if these are poses of the vehicle, "
                          "write `vehicle` and the mounting of the sensor: lidar_x_m, lidar_y_m, "
                          "lidar_z_m, lidar_roll_deg, lidar_pitch_deg, lidar_yaw_deg"});
  } else {
    drive.keys.push_back(
        {"poses_of", "vehicle", "scans overlap only when they are rotated by this yaw"});
    drive.keys.push_back({"lidar_yaw_deg", format_double(chosen.overlap.yaw_deg), ""});
  }
}

void add_poses(const Candidate& chosen, const std::string& remarks, FoundDrive& drive) {
  const PoseOverlap& overlap = chosen.overlap;
  std::string reason = "its count and times fit the scans";
  if (overlap.pairs > 0) {
    reason += concat(", and ", whole_percent(overlap.share),
                     " of the returns from upright surfaces overlap those of scans 2 m away");
  }
  if (!remarks.empty()) reason += ". Not used: " + remarks;
  drive.keys.push_back({"poses", chosen.source.file, reason});
  if (!chosen.source.topic.empty()) {
    drive.keys.push_back({"poses_topic", chosen.source.topic, ""});
  }
  add_owner(chosen, drive);
  drive.poses = chosen.source.file;
  drive.length_m = overlap.length_m;
  for (const RecordedScan& scan : chosen.recording.scans) {
    if (scan.T_world_vehicle) drive.positions_m.push_back(scan.T_world_vehicle->translation());
  }
}

void add_no_poses(const std::string& remarks, FoundDrive& drive) {
  drive.keys.push_back({"poses_of", "sensor",
                        concat("no poses ", remarks.empty() ? "were found" : "fit",
                               ": the poses of the sensor are estimated",
                               (remarks.empty() ? "" : ". Not used: " + remarks))});
}

// Times of the scans: those of a file of stamps that fits, where neither names nor poses have
// times.
void choose_stamps(const FoundScans& found, RecordingOptions& options, FoundDrive& drive) {
  for (const fs::path& file : found.stamp_files) {
    RecordingOptions with_stamps = options;
    with_stamps.stamps = file.string();
    if (!list_recording(with_stamps)) continue;
    options = with_stamps;
    drive.keys.push_back({"stamps", file.string(), "it has one time per scan"});
    return;
  }
}

// Of a bag with several: the one with the most scans.
Result<void> choose_topic(RecordingOptions& options, FoundDrive& drive) {
  if (!is_ros_bag(options.scans)) return {};
  SIGHTLINE_ASSIGN(const std::vector<BagTopic> topics, list_bag_topics(options.scans));
  const BagTopic* chosen = nullptr;
  std::string all;
  for (const BagTopic& topic : topics) {
    all += concat((all.empty() ? "" : ", "), topic.name, " (", topic.type, ", ",
                  topic.message_count, ")");
    if (!is_scan_message(topic.type)) continue;
    drive.other_topics.push_back(topic.name);
    if (!chosen || topic.message_count > chosen->message_count) chosen = &topic;
  }
  if (!chosen) return {};
  options.topic = chosen->name;
  std::erase(drive.other_topics, options.topic);
  drive.keys.push_back(
      {"topic", options.topic,
       concat(chosen->message_count, " messages of ", chosen->type, "; the bag has: ", all)});
  return {};
}

// Of a bag's inertial units the one whose place beside the sensor is known.
Result<void> choose_imu(const RecordingOptions& options, const Recording& recording,
                        FoundDrive& drive) {
  if (!is_ros_bag(options.scans)) return {};
  SIGHTLINE_ASSIGN(const BagTurns turns,
                   read_bag_turns(options.scans, "", recording.container->frame()));
  if (turns.topic.empty()) return {};
  drive.keys.push_back(
      {"imu_topic", turns.topic,
       concat(turns.of_sensor.size(), " turn rates; they are used if they make the map sharper")});
  return {};
}

// Of a bag's topics the only one with speeds of the vehicle.
Result<void> choose_wheel_speed(const RecordingOptions& options, FoundDrive& drive) {
  if (!is_ros_bag(options.scans)) return {};
  SIGHTLINE_ASSIGN(const BagSpeeds speeds, read_bag_speeds(options.scans, ""));
  if (speeds.topic.empty()) return {};
  drive.keys.push_back({"wheel_speed", speeds.topic,
                        concat(speeds.speeds.size(), " messages of ", speeds.type,
                               "; used where scans do not constrain the speed")});
  return {};
}

// Whether the times of scans are known by anything but the rate.
bool has_times(RecordingOptions options) {
  std::vector<std::int64_t> last_ns;
  for (const double rate_hz : {10.0, 20.0}) {
    options.rate_hz = rate_hz;
    const Result<Recording> recording = list_recording(options);
    if (!recording) return true;
    last_ns.push_back(recording->scans.back().stamp_ns);
  }
  return last_ns.front() == last_ns.back();
}

std::string contents_of(const Recording& recording) {
  const std::string count = std::to_string(recording.scans.size());
  if (recording.container) return count + " scans";
  return concat(count, " scans, ", recording.scans.front().name, " to ",
                recording.scans.back().name);
}

}  // namespace

Result<FoundDrive> look_at_drive(const FoundScans& found, const std::string& sensor_name) {
  FoundDrive drive;
  drive.scans = found.scans;
  RecordingOptions options;
  options.scans = found.scans.string();
  SIGHTLINE_TRY(choose_topic(options, drive));
  SIGHTLINE_ASSIGN(Recording recording, list_recording(options));
  if (recording.scans.size() < 2) return no_lidar(found.scans, "a single scan");
  SIGHTLINE_TRY(choose_imu(options, recording, drive));
  SIGHTLINE_TRY(choose_wheel_speed(options, drive));
  SIGHTLINE_ASSIGN(const std::vector<PointCloudFile> samples, read_samples(recording));
  SIGHTLINE_TRY(check_reach(found.scans, samples));
  drive.scan_count = recording.scans.size();
  drive.contents = contents_of(recording);
  add_columns(samples, drive);
  choose_stamps(found, options, drive);
  SensorGuess sensor = guess_sensor(samples);
  prefer_named(sensor_name, found, options.topic, samples, sensor);
  std::string remarks;
  SIGHTLINE_ASSIGN(const std::optional<Candidate> poses,
                   choose_poses(found, recording, options, sensor.height_m.value_or(1.8), remarks));
  if (poses) {
    add_poses(*poses, remarks, drive);
  } else {
    add_no_poses(remarks, drive);
  }
  if (!recording.container && !has_times(poses ? poses->options : options)) {
    drive.keys.push_back(
        {"rate_hz", "10", "the times of the scans are unknown; 10 scans per second are assumed"});
  }
  add_sensor(sensor, recording, drive);
  return drive;
}

}  // namespace sightline
