#include <algorithm>
#include <array>
#include <numbers>

#include "formats/base/units.h"
#include "formats/foreign/text/geodetic_track.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

enum class Field { kTime, kLatitude, kLongitude, kHeight, kRoll, kPitch, kYaw, kHeading, kOther };

struct Column {
  Field field = Field::kOther;
  double unit_rad = kRadPerDeg;  // of angles
};

// Each field with the names that its column may have.
constexpr std::array<std::pair<Field, std::string_view>, 8> kNames = {{
    {Field::kTime, "time timestamp t stamp gpstime utc unixtime seconds"},
    {Field::kLatitude, "latitude lat"},
    {Field::kLongitude, "longitude lon long lng"},
    {Field::kHeight, "height altitude alt hgt h ellipsoidheight ellipsoidalheight"},
    {Field::kRoll, "roll"},
    {Field::kPitch, "pitch"},
    {Field::kYaw, "yaw"},
    {Field::kHeading, "heading azimuth course track bearing cog"},
}};

char separator_of(std::string_view line) {
  for (const char separator : {',', ';', '\t'}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  return ' ';
}

// "Latitude (deg)", "roll_rad", "GPS Time [s]": letters without a unit, which follows them.
Column column_of(std::string_view cell) {
  std::string name;
  for (const char c : cell) {
    if (c == '(' || c == '[') break;
    const bool is_upper = c >= 'A' && c <= 'Z';
    const bool is_letter = is_upper || (c >= 'a' && c <= 'z');
    if (is_letter) name += static_cast<char>(is_upper ? c - 'A' + 'a' : c);
    if (!is_letter && !name.empty()) name += ' ';
  }
  Column column;
  std::vector<std::string_view> words;
  split_words(name, words);
  const bool is_rad = !words.empty() && words.back() == "rad";
  if (is_rad || cell.find("(rad") != std::string_view::npos ||
      cell.find("[rad") != std::string_view::npos) {
    column.unit_rad = 1.0;
  }
  const bool has_unit =
      words.size() > 1 && (is_rad || words.back() == "deg" || words.back() == "m" ||
                           words.back() == "s" || words.back() == "ns");
  if (has_unit) words.pop_back();
  std::string joined;
  for (const std::string_view word : words) joined += word;
  for (const auto& [field, names] : kNames) {
    split_words(names, words);
    if (std::ranges::find(words, joined) != words.end()) column.field = field;
  }
  return column;
}

struct Header {
  char separator = ',';
  std::vector<Column> columns;

  [[nodiscard]] bool has(Field field) const {
    return std::ranges::any_of(columns, [&](const Column& c) { return c.field == field; });
  }
};

Header header_of(std::string_view line) {
  Header header;
  header.separator = separator_of(line);
  for (const std::string_view cell : cells_of(line, header.separator, " \"")) {
    header.columns.push_back(column_of(cell));
  }
  return header;
}

// Degrees; of radians as they are written, in degrees.
double degrees(const Column& column, double value) {
  return column.unit_rad == 1.0 ? value / kRadPerDeg : value;
}

void take(const Column& column, double value, bool is_aviation, GeodeticFix& fix) {
  const double angle_rad = value * column.unit_rad;
  const Field field = column.field;
  if (field == Field::kLatitude) fix.at.latitude_deg = degrees(column, value);
  if (field == Field::kLongitude) fix.at.longitude_deg = degrees(column, value);
  if (field == Field::kHeight) fix.at.altitude_m = value;
  if (field == Field::kRoll) fix.roll_rad = angle_rad;
  if (field == Field::kPitch) fix.pitch_rad = is_aviation ? -angle_rad : angle_rad;
  if (field == Field::kYaw) fix.yaw_rad = angle_rad;
  if (field == Field::kHeading && is_aviation) fix.yaw_rad = 0.5 * std::numbers::pi - angle_rad;
}

Result<GeodeticFix> fix_of(const FileBytes& file, std::size_t line, const Header& header,
                           const std::vector<std::string_view>& cells) {
  if (cells.size() < header.columns.size()) {
    return file.error(ErrorCode::kMalformedPose,
                      concat("found ", cells.size(), " columns, expected ", header.columns.size()),
                      at_line(line));
  }
  GeodeticFix fix;
  const bool is_aviation = !header.has(Field::kYaw);
  for (std::size_t i = 0; i < header.columns.size(); ++i) {
    const Column& column = header.columns[i];
    if (column.field == Field::kOther) continue;
    if (column.field == Field::kTime) {
      fix.stamp_ns = parse_stamp_ns(cells[i]);
      if (fix.stamp_ns) continue;
      return file.error(ErrorCode::kMalformedPose,
                        concat("found ", in_quotes(cells[i]), ", expected a time in seconds"),
                        at_line(line));
    }
    const std::optional<double> value = finite_number(cells[i]);
    if (!value) {
      return file.error(ErrorCode::kMalformedPose,
                        concat("found ", in_quotes(cells[i]), ", expected a finite number"),
                        at_line(line));
    }
    take(column, *value, is_aviation, fix);
  }
  SIGHTLINE_TRY(check_fix(file, line, fix));
  return fix;
}

}  // namespace

bool names_latitude_and_longitude(std::string_view line) {
  const Header header = header_of(line);
  return header.has(Field::kLatitude) && header.has(Field::kLongitude);
}

Result<GeodeticTrack> parse_gnss_csv(const FileBytes& file) {
  GeodeticTrack track;
  std::optional<Header> header;
  LineReader lines(file.text());
  for (std::string_view line; lines.next(line);) {
    if (line.find_first_not_of(" \t") == std::string_view::npos || line.starts_with('#')) continue;
    if (!header) {
      header = header_of(line);
      if (header->has(Field::kLatitude) && header->has(Field::kLongitude)) continue;
      return file.error(ErrorCode::kMissingField,
                        "found no columns latitude and longitude in the first line",
                        at_line(lines.number()));
    }
    SIGHTLINE_ASSIGN(const GeodeticFix fix, fix_of(file, lines.number(), *header,
                                                   cells_of(line, header->separator, " \"")));
    track.fixes.push_back(fix);
  }
  if (header && !header->has(Field::kHeight)) {
    track.warnings.push_back(file.file + ": no height is given, 0 m is used");
  }
  return track;
}

}  // namespace sightline
