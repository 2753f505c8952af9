#include "formats/foreign/text/geodetic_track.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/base/files/regular_file.h"
#include "formats/base/portable_math.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/geometry.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// Nearer than this, noise says where a vehicle goes.
constexpr double kLeastWay_m = 1.0;

Eigen::Matrix3d attitude(double yaw_rad, double pitch_rad, double roll_rad) {
  return rotation_matrix({Eigen::Vector3d::UnitZ(), yaw_rad}) *
         rotation_matrix({Eigen::Vector3d::UnitY(), pitch_rad}) *
         rotation_matrix({Eigen::Vector3d::UnitX(), roll_rad});
}

// Finds the last place before another that is at least a metre away from it. Where a vehicle stands
// that is many places back, so boxes of 2, 4, 8, ... places are skipped at once.
class PlacesBefore {
 public:
  explicit PlacesBefore(const std::vector<Eigen::Vector2d>& places_m) {
    std::vector<Box> boxes;
    for (const Eigen::Vector2d& place_m : places_m) boxes.emplace_back(place_m, place_m);
    while (boxes.size() > 1) {
      std::vector<Box> wider;
      for (std::size_t i = 1; i < boxes.size(); i += 2) {
        wider.push_back(boxes[i - 1].merged(boxes[i]));
      }
      levels_.push_back(std::exchange(boxes, std::move(wider)));
    }
    levels_.push_back(std::move(boxes));
  }

  // Its index; 0 where all are nearer.
  [[nodiscard]] std::size_t last_apart(std::size_t at) const {
    const Eigen::Vector2d place_m = levels_.front()[at].min();
    std::size_t end = at;  // the places from here on are near
    std::size_t level = 0;
    while (end > 0) {
      const std::size_t size = std::size_t{1} << level;
      const bool ends_a_box = end % size == 0;
      if (ends_a_box && is_near(place_m, level, end / size - 1)) {
        end -= size;
        if (level + 1 < levels_.size()) ++level;
      } else if (level > 0) {
        --level;
      } else {
        return end - 1;
      }
    }
    return 0;
  }

 private:
  using Box = Eigen::AlignedBox2d;

  // Whether all of a box is; where rounding could decide, its places do.
  [[nodiscard]] bool is_near(const Eigen::Vector2d& place_m, std::size_t level,
                             std::size_t i) const {
    const Box& box = levels_[level][i];
    if (level == 0) return (place_m - box.min()).norm() < kLeastWay_m;
    constexpr double kRounding_m = 1e-6;
    const Eigen::Vector2d farthest_m =
        (place_m - box.min()).cwiseAbs().cwiseMax((place_m - box.max()).cwiseAbs());
    return farthest_m.norm() < kLeastWay_m - kRounding_m;
  }

  std::vector<std::vector<Box>> levels_;  // of 1, 2, 4, ... places from 0 on
};

// From the last place a metre behind to the next a metre ahead; none where there is neither.
std::vector<std::optional<double>> directions_of_travel(const std::vector<PoseRow>& rows) {
  std::vector<Eigen::Vector2d> places_m;
  for (const PoseRow& row : rows) {
    places_m.emplace_back(row.T_world_vehicle.translation().head<2>());
  }
  const PlacesBefore behind(places_m);
  const PlacesBefore ahead({places_m.rbegin(), places_m.rend()});
  const std::size_t last = rows.size() - 1;
  std::vector<std::optional<double>> directions_rad(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Eigen::Vector2d way_m =
        places_m[last - ahead.last_apart(last - i)] - places_m[behind.last_apart(i)];
    if (way_m.norm() < kLeastWay_m) continue;
    directions_rad[i] = portable_atan2(way_m.y(), way_m.x());
  }
  return directions_rad;
}

// Headings of the fixes that have none; a vehicle that stands keeps the last one.
Result<void> add_directions(const std::vector<GeodeticFix>& fixes, const std::string& path,
                            std::vector<PoseRow>& rows) {
  std::vector<std::optional<double>> yaws_rad = directions_of_travel(rows);
  std::optional<double> last_rad;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (fixes[i].yaw_rad) continue;
    if (!yaws_rad[i]) yaws_rad[i] = last_rad;
    last_rad = yaws_rad[i];
  }
  for (std::size_t i = rows.size(); i-- > 0;) {  // before it first moved
    if (fixes[i].yaw_rad) continue;
    if (!yaws_rad[i]) yaws_rad[i] = last_rad;
    if (!yaws_rad[i]) {
      return Error{ErrorCode::kMalformedPose,
                   "no heading is given and the vehicle moves less than 1 m, too little to derive "
                   "one: add a column heading or yaw",
                   path};
    }
    last_rad = yaws_rad[i];
    rows[i].T_world_vehicle.linear() =
        attitude(*yaws_rad[i], fixes[i].pitch_rad, fixes[i].roll_rad);
  }
  return {};
}

std::string first_line(const std::filesystem::path& path) {
  constexpr std::size_t kLongest = 4096;
  const Result<std::string> text = read_beginning(path.string(), kLongest);
  if (!text) return "";
  LineReader lines(*text);
  for (std::string_view line; lines.next(line);) {
    if (!line.empty() && !line.starts_with('#')) return std::string(line);
  }
  return "";
}

// A few poses with the time of the one before them; more are refused by check_times.
void leave_out_repeated(const std::filesystem::path& path, GeodeticTrack& track) {
  std::vector<GeodeticFix> kept;
  for (const GeodeticFix& fix : track.fixes) {
    const bool is_repeated = !kept.empty() && fix.stamp_ns && fix.stamp_ns == kept.back().stamp_ns;
    if (!is_repeated) kept.push_back(fix);
  }
  const std::size_t repeated = track.fixes.size() - kept.size();
  const double most = kRepeatedTimesShare * static_cast<double>(track.fixes.size());
  if (repeated == 0 || static_cast<double>(repeated) > most) return;
  track.fixes = std::move(kept);
  track.warnings.push_back(concat(path.string(), ": ", repeated,
                                  " poses have the time of the one before them and are skipped"));
}

Result<void> check_times(const GeodeticTrack& track, const std::filesystem::path& path) {
  for (std::size_t i = 1; i < track.fixes.size(); ++i) {
    const std::optional<std::int64_t>& before = track.fixes[i - 1].stamp_ns;
    const std::optional<std::int64_t>& now = track.fixes[i].stamp_ns;
    if (before && now && *now <= *before) {
      return Error{ErrorCode::kTimeRunsBackwards,
                   concat("found time ", format_stamp(*now), " s, expected one after ",
                          format_stamp(*before), " s"),
                   path.string(), concat("pose ", i)};
    }
  }
  return {};
}

// KITTI's raw recordings (A. Geiger et al., "Vision meets Robotics: The KITTI Dataset", IJRR 2013,
// devkit readme): oxts/data/0000000000.txt, ... with 30 numbers each, oxts/timestamps.txt.

constexpr std::size_t kLargestFile = 65'536;

// Latitude and longitude in degrees, altitude in metres; roll (positive with the left side up),
// pitch (positive with the nose down) and yaw (from east, counter-clockwise) in radians.
Result<GeodeticFix> fix_of(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(path, kLargestFile));
  const FileBytes file = FileBytes::of_text(text, path.string());
  std::vector<std::string_view> words;
  split_words(file.text(), words, " \t\r\n");
  std::array<double, 6> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<double> number = i < words.size() ? finite_number(words[i]) : std::nullopt;
    if (!number) {
      return file.error(ErrorCode::kMalformedPose,
                        "expected numbers: latitude, longitude, altitude, roll, pitch, yaw, ...",
                        at_line(1));
    }
    numbers[i] = *number;
  }
  GeodeticFix fix;
  fix.at = {numbers[0], numbers[1], numbers[2]};
  fix.roll_rad = numbers[3];
  fix.pitch_rad = numbers[4];
  fix.yaw_rad = numbers[5];
  SIGHTLINE_TRY(check_fix(file, 1, fix));
  return fix;
}

Result<std::vector<std::filesystem::path>> list_files(const std::filesystem::path& folder) {
  std::error_code failure;
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    if (entry->path().extension() == ".txt") files.push_back(entry->path());
  }
  if (failure) {
    return Error{ErrorCode::kCannotOpen, "cannot list the folder: " + failure.message(),
                 folder.string()};
  }
  std::ranges::sort(files);
  if (!files.empty()) return files;
  return Error{ErrorCode::kMalformedPose,
               "a folder of poses is KITTI's oxts (data/*.txt and timestamps.txt); found no .txt",
               folder.string()};
}

// A folder oxts, or data/ in it.
Result<GeodeticTrack> read_oxts(const std::filesystem::path& folder) {
  std::error_code failure;
  const bool is_whole = std::filesystem::is_directory(folder / "data", failure);
  const std::filesystem::path data = is_whole ? folder / "data" : folder;
  const std::filesystem::path beside =
      (is_whole ? folder : (folder / "..").lexically_normal()) / "timestamps.txt";
  SIGHTLINE_ASSIGN(const std::vector<std::filesystem::path> files, list_files(data));
  GeodeticTrack track;
  for (const std::filesystem::path& file : files) {
    SIGHTLINE_ASSIGN(const GeodeticFix fix, fix_of(file));
    track.fixes.push_back(fix);
  }
  if (!std::filesystem::exists(beside, failure)) return track;
  SIGHTLINE_ASSIGN(const std::vector<std::int64_t> stamps_ns, read_stamps(beside));
  if (stamps_ns.size() != files.size()) {
    track.warnings.push_back(concat(beside.string(), " has ", stamps_ns.size(), " times for ",
                                    files.size(), " poses and is not used"));
    return track;
  }
  for (std::size_t i = 0; i < files.size(); ++i) track.fixes[i].stamp_ns = stamps_ns[i];
  return track;
}

}  // namespace

Result<void> check_fix(const FileBytes& file, std::size_t line, const GeodeticFix& fix) {
  const Geodetic& at = fix.at;
  const bool is_on_earth = std::abs(at.latitude_deg) <= 90.0 &&
                           std::abs(at.longitude_deg) <= 360.0 && std::abs(at.altitude_m) < 1e5;
  const bool is_finite = std::isfinite(fix.yaw_rad.value_or(0.0)) && std::isfinite(fix.pitch_rad) &&
                         std::isfinite(fix.roll_rad);
  if (is_on_earth && is_finite) return {};
  return file.error(
      ErrorCode::kMalformedPose,
      concat("found latitude ", format_double(at.latitude_deg), ", longitude ",
             format_double(at.longitude_deg), ", height ", format_double(at.altitude_m),
             " m and its angles, expected a position on Earth in degrees and metres"),
      at_line(line));
}

bool is_geodetic(const std::filesystem::path& path) {
  std::error_code failure;
  if (std::filesystem::is_directory(path, failure)) return true;
  const std::string line = first_line(path);
  return line.starts_with('$') || names_latitude_and_longitude(line);
}

Result<GeodeticTrack> read_geodetic_track(const std::filesystem::path& path) {
  std::error_code failure;
  GeodeticTrack track;
  if (std::filesystem::is_directory(path, failure)) {
    SIGHTLINE_ASSIGN(track, read_oxts(path));
  } else {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
    const FileBytes file{bytes, path.string()};
    SIGHTLINE_ASSIGN(track,
                     first_line(path).starts_with('$') ? parse_nmea(file) : parse_gnss_csv(file));
  }
  leave_out_repeated(path, track);
  SIGHTLINE_TRY(check_times(track, path));
  return track;
}

Result<TrackInWorld> in_world(const GeodeticTrack& track, const std::string& world,
                              const std::string& path) {
  if (track.fixes.empty()) return Error{ErrorCode::kMalformedPose, "found no pose", path};
  TrackInWorld found;
  found.warnings = track.warnings;
  std::string name = world;
  if (name == "local") {
    name = enu_world_name(track.fixes.front().at);
    found.warnings.push_back(concat(path,
                                    ": coordinates are metres from its first pose. For several "
                                    "drives set one world under annotation: \"world: ",
                                    name, "\""));
  }
  SIGHTLINE_ASSIGN(const World parsed, parse_world(name));
  bool has_headings = true;
  for (const GeodeticFix& fix : track.fixes) {
    PoseRow& row = found.rows.emplace_back();
    row.stamp_ns = fix.stamp_ns;
    SIGHTLINE_ASSIGN(row.T_world_vehicle, enu_axes(parsed, fix.at));
    has_headings = has_headings && fix.yaw_rad.has_value();
    if (!fix.yaw_rad) continue;
    const Eigen::Matrix3d turned =
        row.T_world_vehicle.linear() * attitude(*fix.yaw_rad, fix.pitch_rad, fix.roll_rad);
    row.T_world_vehicle.linear() = turned;
  }
  if (has_headings) return found;
  SIGHTLINE_TRY(add_directions(track.fixes, path, found.rows));
  found.warnings.push_back(
      path +
      ": poses without a heading take it from the direction of travel, with roll and pitch of 0");
  return found;
}

}  // namespace sightline
