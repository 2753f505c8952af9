#include <array>
#include <cmath>
#include <numbers>

#include "formats/base/units.h"
#include "formats/foreign/text/geodetic_track.h"
#include "formats/foreign/text/text_lines.h"

// NMEA 0183: one sentence a line, "$GPGGA,123519.00,4807.038,N,...*47".

namespace sightline {
namespace {

constexpr std::int64_t kDay_ns = 86'400 * kSecond_ns;

using Cells = std::vector<std::string_view>;

// What stands between $ and *, where the checksum behind that is right or missing.
std::optional<std::string_view> sentence_of(std::string_view line) {
  const std::size_t begin = line.find('$');
  if (begin == std::string_view::npos) return std::nullopt;
  const std::size_t star = line.find('*', begin);
  const std::string_view body = line.substr(begin + 1, star - begin - 1);
  if (star == std::string_view::npos) return line.substr(begin + 1);
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  unsigned given_sum = 0;
  const std::string_view digits = line.substr(star + 1, 2);
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), given_sum, 16);
  if (end.ec != std::errc() || given_sum != sum) return std::nullopt;
  return body;
}

// "4807.038", "N": degrees and minutes.
std::optional<double> degrees_of(std::string_view cell, std::string_view side) {
  const std::optional<double> value = to_number<double>(cell);
  if (!value || !(*value >= 0.0 && *value < 36000.0)) return std::nullopt;
  const double whole = std::floor(*value / 100.0);
  const double degrees = whole + (*value - 100.0 * whole) / 60.0;
  return side == "S" || side == "W" ? -degrees : degrees;
}

std::optional<int> two_digits(std::string_view cell, std::size_t at) {
  if (cell.size() < at + 2) return std::nullopt;
  return to_number<int>(cell.substr(at, 2));
}

// "123519.25" of the day.
std::optional<std::int64_t> time_of_day_ns(std::string_view cell) {
  const std::optional<int> hours = two_digits(cell, 0);
  const std::optional<int> minutes = two_digits(cell, 2);
  if (!hours || !minutes || cell.size() < 6) return std::nullopt;
  const std::optional<double> seconds = to_number<double>(cell.substr(4));
  const bool is_time = *hours >= 0 && *hours < 24 && *minutes >= 0 && *minutes < 60 && seconds &&
                       *seconds >= 0.0 && *seconds < 61.0;
  if (!is_time) return std::nullopt;
  return (*hours * 3600 + *minutes * 60) * kSecond_ns +
         static_cast<std::int64_t>(std::llround(*seconds * 1e9));
}

class NmeaReader {
 public:
  explicit NmeaReader(const FileBytes& file) : file_(file) {}

  Result<void> take(std::size_t line, std::string_view sentence) {
    const Cells cells = cells_of(sentence, ',', "");
    const std::string_view name = cells.front();
    if (name.ends_with("GGA")) return take_place(line, cells);
    if (name.ends_with("RMC") && cells.size() > 9) {
      take_date(cells[1], two_digits(cells[9], 0), two_digits(cells[9], 2),
                two_digits(cells[9], 4));
    }
    if (name.ends_with("ZDA") && cells.size() > 4) {
      take_date(cells[1], two_digits(cells[2], 0), two_digits(cells[3], 0),
                two_digits(cells[4], 2));
    }
    if (name == "PASHR" && cells.size() > 5) take_attitude(cells);
    if (name.ends_with("HDT") && cells.size() > 1) take_heading(cells[1]);
    return {};
  }

  GeodeticTrack finish(std::size_t wrong_sentences) {
    if (wrong_sentences > 0) {
      warn(concat(wrong_sentences, " lines are not sentences with a correct checksum"));
    }
    if (without_fix_ > 0) warn(concat(without_fix_, " positions without a fix are skipped"));
    if (repeated_ > 0) {
      warn(concat(repeated_,
                  " positions have the time of the position before them, as receivers of several "
                  "satellite systems write; the one with the better fix is used, else the first"));
    }
    if (!date_ns_) warn("no date is given (RMC, ZDA); times count from midnight");
    for (GeodeticFix& fix : track_.fixes) *fix.stamp_ns += date_ns_.value_or(0);
    return std::move(track_);
  }

 private:
  void warn(const std::string& what) { track_.warnings.push_back(concat(file_.file, ": ", what)); }

  Result<void> take_place(std::size_t line, const Cells& cells) {
    if (cells.size() < 12 || cells[6].empty() || cells[6] == "0") {
      ++without_fix_;
      return {};
    }
    const std::optional<std::int64_t> time_ns = time_of_day_ns(cells[1]);
    const std::optional<double> latitude = degrees_of(cells[2], cells[3]);
    const std::optional<double> longitude = degrees_of(cells[4], cells[5]);
    const std::optional<double> altitude = to_number<double>(cells[9]);
    const std::optional<double> geoid = to_number<double>(cells[11]);
    if (!time_ns || !latitude || !longitude || !altitude) {
      return file_.error(ErrorCode::kMalformedPose,
                         "found a GGA sentence without time, position or altitude", at_line(line));
    }
    GeodeticFix fix;
    fix.at = {*latitude, *longitude, *altitude + geoid.value_or(0.0)};
    SIGHTLINE_TRY(check_fix(file_, line, fix));
    fix.stamp_ns = since_first_day_ns(*time_ns);
    const int rank = rank_of(cells[6]);
    const bool is_repeated = !track_.fixes.empty() && track_.fixes.back().stamp_ns == fix.stamp_ns;
    if (is_repeated) {
      ++repeated_;
      if (rank > last_rank_) {
        track_.fixes.back().at = fix.at;
        last_rank_ = rank;
      }
      return {};
    }
    last_rank_ = rank;
    if (next_yaw_rad_) fix.yaw_rad = std::exchange(next_yaw_rad_, std::nullopt);
    track_.fixes.push_back(fix);
    return {};
  }

  // Of the quality of a GGA sentence: 4 (RTK fixed) is the most accurate, then 5 (RTK float), 3, 2
  // (differential) and 1; others are estimates.
  static int rank_of(std::string_view quality) {
    constexpr std::string_view kAscending = "12354";
    const std::size_t place = kAscending.find(quality);
    return place == std::string_view::npos ? -1 : static_cast<int>(place);
  }

  // Midnights that passed since the first time count.
  std::int64_t since_first_day_ns(std::int64_t time_ns) {
    const bool is_next_day = last_time_ns_ && time_ns < *last_time_ns_ - kDay_ns / 2;
    if (is_next_day) days_ns_ += kDay_ns;
    last_time_ns_ = time_ns;
    return days_ns_ + time_ns;
  }

  void take_date(std::string_view time, std::optional<int> day, std::optional<int> month,
                 std::optional<int> year) {
    if (date_ns_ || !day || !month || !year || !time_of_day_ns(time)) return;
    std::array<char, 16> date{};
    std::snprintf(date.data(), date.size(), "20%02d-%02d-%02d", *year % 100, *month % 100,
                  *day % 100);
    const std::optional<std::int64_t> midnight_ns = parse_date_time_ns(date.data(), "00:00:00");
    if (midnight_ns) date_ns_ = *midnight_ns - days_ns_;
  }

  // $PASHR,time,heading,T,roll,pitch,...: of the place of that time, which came before.
  void take_attitude(const Cells& cells) {
    const std::optional<double> heading = to_number<double>(cells[2]);
    const std::optional<double> roll = to_number<double>(cells[4]);
    const std::optional<double> pitch = to_number<double>(cells[5]);
    const std::optional<std::int64_t> time_ns = time_of_day_ns(cells[1]);
    if (!heading || !roll || !pitch || !time_ns || track_.fixes.empty()) return;
    GeodeticFix& fix = track_.fixes.back();
    if (*fix.stamp_ns % kDay_ns != *time_ns) return;
    fix.yaw_rad = yaw_of(*heading);
    fix.roll_rad = *roll * kRadPerDeg;
    fix.pitch_rad = -*pitch * kRadPerDeg;
  }

  // $HDT has no time: of the place before it, or, where the file begins with one, of the next.
  void take_heading(std::string_view cell) {
    const std::optional<double> heading = to_number<double>(cell);
    if (!heading || !std::isfinite(*heading)) return;
    if (track_.fixes.empty()) comes_first_ = true;
    if (comes_first_) {
      next_yaw_rad_ = yaw_of(*heading);
    } else if (!track_.fixes.back().yaw_rad) {
      track_.fixes.back().yaw_rad = yaw_of(*heading);
    }
  }

  static double yaw_of(double heading_deg) {
    return 0.5 * std::numbers::pi - heading_deg * kRadPerDeg;
  }

  const FileBytes& file_;
  GeodeticTrack track_;
  std::size_t without_fix_ = 0;
  std::size_t repeated_ = 0;
  int last_rank_ = 0;  // of the last position
  std::optional<std::int64_t> last_time_ns_;
  std::int64_t days_ns_ = 0;
  std::optional<std::int64_t> date_ns_;  // midnight before the first time
  bool comes_first_ = false;
  std::optional<double> next_yaw_rad_;
};

}  // namespace

Result<GeodeticTrack> parse_nmea(const FileBytes& file) {
  NmeaReader reader(file);
  std::size_t wrong = 0;
  LineReader lines(file.text());
  for (std::string_view line; lines.next(line);) {
    if (line.empty()) continue;
    const std::optional<std::string_view> sentence = sentence_of(line);
    if (!sentence) {
      ++wrong;
      continue;
    }
    SIGHTLINE_TRY(reader.take(lines.number(), *sentence));
  }
  return reader.finish(wrong);
}

}  // namespace sightline
