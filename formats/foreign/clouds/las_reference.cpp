#include "formats/foreign/clouds/las_reference.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <span>
#include <vector>

#include "formats/foreign/text/text_lines.h"

// A LAS file names its reference system as GeoTIFF keys (OGC 19-008r4: a table of four 16-bit
// numbers each: key, place, count, value), as WKT (OGC 01-009 or 18-010), as both or not at all.

namespace sightline {
namespace {

constexpr std::string_view kUser = "LASF_Projection";
constexpr std::size_t kGeoKeys = 34735;
constexpr std::size_t kWkt = 2112;

struct Record {
  std::string_view user;
  std::size_t id = 0;
  std::span<const std::byte> bytes;
  std::size_t offset = 0;  // in the file
};

// A record begins with two reserved bytes, its user in 16, its number in two, its length in two
// (eight of an extended one), and a description in 32.
constexpr std::size_t kUserAt = 2;
constexpr std::size_t kUserSize = 16;
constexpr std::size_t kIdAt = 18;
constexpr std::size_t kLengthAt = 20;

template <class Length>
void add_records(const FileBytes& file, std::size_t at, std::size_t count, std::size_t end,
                 std::vector<Record>& records) {
  constexpr std::size_t kHead = kLengthAt + sizeof(Length) + 32;
  for (std::size_t i = 0; i < count && at < end && end - at >= kHead; ++i) {
    Record record;
    record.user = file.text().substr(at + kUserAt, kUserSize);
    record.user = record.user.substr(0, record.user.find('\0'));
    record.id = read_at<std::uint16_t>(file.bytes, at + kIdAt);
    const auto length = read_at<Length>(file.bytes, at + kLengthAt);
    if (length > end - at - kHead) return;
    record.bytes = file.bytes.subspan(at + kHead, length);
    record.offset = at;
    records.push_back(record);
    at += kHead + length;
  }
}

std::vector<Record> records_of(const FileBytes& file, const LasRecordPlaces& places) {
  std::vector<Record> records;
  add_records<std::uint16_t>(file, places.first, places.count, places.end, records);
  add_records<std::uint64_t>(file, places.extended_first, places.extended_count, file.bytes.size(),
                             records);
  return records;
}

Error no_metres(const FileBytes& file, const Record& record, const std::string& found) {
  return file.error(ErrorCode::kUnsupportedFormat,
                    "found coordinates " + found +
                        ", expected metres with z up; convert it with `pdal translate in.las "
                        "out.las reprojection --filters.reprojection.out_srs=EPSG:32632` (the UTM "
                        "zone of the place, heights in metres)",
                    at_byte(record.offset));
}

// EPSG's codes of lengths: 9001 is the metre, the others up to 9099 are feet, chains and the like.
bool is_other_length(std::size_t unit) { return unit > 9001 && unit < 9100; }

Result<void> check_geo_keys(const FileBytes& file, const Record& record) {
  constexpr std::size_t kModelType = 1024;
  constexpr std::size_t kLinearUnits = 3076;
  constexpr std::size_t kVerticalUnits = 4099;
  constexpr std::size_t kGeographic = 2;
  constexpr std::size_t kGeocentric = 3;
  constexpr std::size_t kEntry = 4 * sizeof(std::uint16_t);
  for (std::size_t at = kEntry; at + kEntry <= record.bytes.size(); at += kEntry) {
    const auto entry = read_at<std::array<std::uint16_t, 4>>(record.bytes, at);
    const std::size_t key = entry[0];
    const std::size_t value = entry[3];
    if (entry[1] != 0) continue;  // the value stands in another record
    if (key == kModelType && value == kGeographic) {
      return no_metres(file, record, "in degrees of longitude and latitude");
    }
    if (key == kModelType && value == kGeocentric)
      return no_metres(file, record, "from Earth's centre");
    if ((key == kLinearUnits || key == kVerticalUnits) && is_other_length(value)) {
      return no_metres(file, record, "in the unit EPSG:" + std::to_string(value));
    }
  }
  return {};
}

// A keyword of WKT, and what stands in its brackets.
struct WktNode {
  std::string keyword;  // large letters
  std::string_view body;
};

// The nodes one level down: "A["x",1],B[2]" has two. Stops where brackets do not match.
std::vector<WktNode> wkt_nodes(std::string_view text) {
  std::vector<WktNode> nodes;
  std::string word;
  std::size_t begin = 0;
  int depth = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted) continue;
    if (c == '[' || c == '(') {
      if (depth++ == 0) begin = i + 1;
    } else if (c == ']' || c == ')') {
      if (--depth == 0) nodes.push_back({word, text.substr(begin, i - begin)});
      if (depth < 0) return nodes;
    } else if (depth == 0) {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
        word += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      } else {
        word.clear();
      }
      continue;
    }
    if (depth == 0) word.clear();
  }
  return nodes;
}

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

// "US survey foot" of "US survey foot",0.3048006,AUTHORITY[...]; nothing where it is a metre.
std::optional<std::string> other_unit(std::string_view body) {
  std::vector<std::string_view> parts;
  split_words(body, parts, ",");
  const std::string name(parts.empty() ? "" : parts[0]);
  std::vector<std::string_view> words;
  if (parts.size() > 1) split_words(parts[1], words, " \t\r\n\"");
  const std::optional<double> metres =
      words.empty() ? std::nullopt : to_number<double>(words.front());
  const bool is_foot =
      name.find("oot") != std::string::npos || name.find("eet") != std::string::npos;
  if (is_foot || (metres && *metres != 1.0)) return name;
  return std::nullopt;
}

// What is wrong with a system of lengths: the first unit in it that is no metre. Units of angles
// stand in its geographic base and in the parameters of its projection.
std::optional<std::string> other_unit_of_lengths(std::string_view body) {
  for (const WktNode& node : wkt_nodes(body)) {
    std::optional<std::string> unit;
    if (is_one_of(node.keyword, {"UNIT", "LENGTHUNIT"})) unit = other_unit(node.body);
    if (is_one_of(node.keyword, {"CS", "AXIS"})) unit = other_unit_of_lengths(node.body);
    if (unit) return unit;
  }
  return std::nullopt;
}

Result<void> check_wkt(const FileBytes& file, const Record& record, std::string_view text,
                       int depth = 0) {
  constexpr int kDeepest = 8;
  for (const WktNode& node : wkt_nodes(text)) {
    if (is_one_of(node.keyword, {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"})) {
      return no_metres(file, record, "in degrees of longitude and latitude");
    }
    if (is_one_of(node.keyword, {"GEOCCS", "GEODCRS", "GEODETICCRS"})) {
      return no_metres(file, record, "of a geodetic system");
    }
    const bool has_lengths =
        is_one_of(node.keyword, {"PROJCS", "PROJCRS", "PROJECTEDCRS", "VERT_CS", "VERTCRS",
                                 "VERTICALCRS", "LOCAL_CS", "ENGCRS"});
    const std::optional<std::string> unit =
        has_lengths ? other_unit_of_lengths(node.body) : std::nullopt;
    if (unit) return no_metres(file, record, "in the unit " + in_quotes(*unit));
    const bool has_parts =
        is_one_of(node.keyword, {"COMPD_CS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS"});
    if (has_parts && depth < kDeepest) SIGHTLINE_TRY(check_wkt(file, record, node.body, depth + 1));
  }
  return {};
}

}  // namespace

Result<void> check_reference(const FileBytes& file, const LasRecordPlaces& places) {
  for (const Record& record : records_of(file, places)) {
    if (record.user != kUser) continue;
    if (record.id == kGeoKeys) SIGHTLINE_TRY(check_geo_keys(file, record));
    if (record.id != kWkt) continue;
    const std::string_view text(reinterpret_cast<const char*>(record.bytes.data()),
                                record.bytes.size());
    SIGHTLINE_TRY(check_wkt(file, record, text));
  }
  return {};
}

Result<void> check_extent(const FileBytes& file, const PointCloudFile& cloud,
                          const Eigen::Vector3d& scale) {
  constexpr double kSmallest = 0.1;
  constexpr double kFinest = 1e-5;
  constexpr std::size_t kFewest = 100;  // fewer are no scan, and may be anything
  if (cloud.points_m.size() < kFewest || scale.head<2>().maxCoeff() > kFinest) return {};
  Eigen::Vector2d low = cloud.points_m.front().head<2>();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector3d& point : cloud.points_m) {
    low = low.cwiseMin(point.head<2>());
    high = high.cwiseMax(point.head<2>());
  }
  const bool is_on_earth =
      low.x() >= -180.0 && high.x() <= 360.0 && low.y() >= -90.0 && high.y() <= 90.0;
  if (!is_on_earth || (high - low).maxCoeff() > kSmallest) return {};
  return no_metres(file, {},
                   "that all lie within 0.1 of each other, like degrees of longitude and latitude");
}

}  // namespace sightline
