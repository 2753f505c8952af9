#include <algorithm>
#include <chrono>
#include <cmath>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/geodetic_parsers.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/foreign/text/text_lines.h"

// KITTI's raw recordings (A. Geiger et al., "Vision meets Robotics: The KITTI Dataset", IJRR 2013,
// devkit readme): oxts/data/0000000000.txt, ... with 30 numbers each, oxts/timestamps.txt.

namespace sightline {
namespace {

constexpr std::size_t kLargestFile = 65'536;

// Latitude and longitude in degrees, altitude in metres; roll (positive with the left side up),
// pitch (positive with the nose down) and yaw (from east, counter-clockwise) in radians.
Result<GeodeticFix> fix_of(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(path, kLargestFile));
  const FileBytes file{std::as_bytes(std::span(text.data(), text.size())), path.string()};
  std::vector<std::string_view> words;
  split_words(file.text(), words, " \t\r\n");
  std::array<double, 6> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<double> number =
        i < words.size() ? to_number<double>(words[i]) : std::nullopt;
    if (!number || !std::isfinite(*number)) {
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

}  // namespace

std::optional<std::int64_t> parse_date_time_ns(std::string_view date, std::string_view time) {
  namespace chrono = std::chrono;
  const auto number = [](std::string_view text, std::size_t at, std::size_t length) {
    return to_number<int>(text.substr(at, length));
  };
  if (date.size() != 10 || date[4] != '-' || date[7] != '-') return std::nullopt;
  if (time.size() < 8 || time[2] != ':' || time[5] != ':') return std::nullopt;
  const std::optional<int> year = number(date, 0, 4);
  const std::optional<int> month = number(date, 5, 2);
  const std::optional<int> day = number(date, 8, 2);
  const std::optional<int> hours = number(time, 0, 2);
  const std::optional<int> minutes = number(time, 3, 2);
  const std::optional<std::int64_t> seconds_ns = parse_stamp_ns(time.substr(6));
  constexpr std::int64_t kMinute_ns = 60'000'000'000;
  if (!year || !month || !day || !hours || !minutes || !seconds_ns) return std::nullopt;
  if (*year < 1970 || *year > 2100 || *month < 1 || *day < 1) return std::nullopt;
  if (*hours < 0 || *hours > 23 || *minutes < 0 || *minutes > 59) return std::nullopt;
  if (*seconds_ns < 0 || *seconds_ns > kMinute_ns) return std::nullopt;
  const chrono::year_month_day when{chrono::year(*year),
                                    chrono::month(static_cast<unsigned>(*month)),
                                    chrono::day(static_cast<unsigned>(*day))};
  if (!when.ok()) return std::nullopt;
  const auto days = chrono::sys_days(when).time_since_epoch().count();
  return (std::int64_t{days} * 1440 + *hours * 60 + *minutes) * kMinute_ns + *seconds_ns;
}

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
    track.warnings.push_back(beside.string() + " has " + std::to_string(stamps_ns.size()) +
                             " times for " + std::to_string(files.size()) +
                             " poses and is not used");
    return track;
  }
  for (std::size_t i = 0; i < files.size(); ++i) track.fixes[i].stamp_ns = stamps_ns[i];
  return track;
}

}  // namespace sightline
