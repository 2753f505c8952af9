#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

// LAS 1.0 to 1.4 (ASPRS): a public header block, variable length records of which those of the
// reference system matter, and point records of fixed length. All point formats begin with x, y, z
// (int32, scaled) and intensity; they differ in where the GPS time stands, if there is one, and in
// which bit says that a point is withheld: deleted, but for its bytes.

namespace sightline {
namespace {

// Where the header says that variable length records lie.
struct LasRecordPlaces {
  std::size_t first = 0;  // byte behind the header
  std::size_t count = 0;
  std::size_t end = 0;               // byte of the first point
  std::uint64_t extended_first = 0;  // of LAS 1.4, behind the points
  std::size_t extended_count = 0;
};

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
  return file.error(
      ErrorCode::kUnsupportedFormat,
      concat("found coordinates ", found,
             ", expected metres with z up; convert it with `pdal translate in.las "
             "out.las reprojection --filters.reprojection.out_srs=EPSG:32632` (the UTM "
             "zone of the place, heights in metres)"),
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
      return no_metres(file, record, concat("in the unit EPSG:", value));
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

// Refuses (unsupported-format, says how to convert) coordinates that are no lengths in metres along
// three axes at right angles: longitude and latitude in degrees, geocentric ones (whose z is not
// up) and feet. A file that says nothing of them passes, and so does one whose records are damaged.
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

// Degrees in a file that does not say so: x and y within a dm of each other, scaled finer than 10
// um, and inside 360 by 90. No scan of a LiDAR fits into a box of 10 cm; in degrees it is 11 km.
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
  return no_metres(file, {}, "within 0.1 of each other, as in degrees of longitude and latitude");
}

// Byte offsets in the public header block.
constexpr std::size_t kVersionAt = 24;
constexpr std::size_t kHeaderSizeAt = 94;
constexpr std::size_t kDataOffsetAt = 96;
constexpr std::size_t kRecordsAt = 100;
constexpr std::size_t kFormatAt = 104;
constexpr std::size_t kRecordLengthAt = 105;
constexpr std::size_t kCountAt = 107;
constexpr std::size_t kScaleAt = 131;
constexpr std::size_t kOffsetAt = 155;
constexpr std::size_t kWaveformsAt = 227;
constexpr std::size_t kExtendedAt = 235;
constexpr std::size_t kExtendedCountAt = 243;
constexpr std::size_t kCount14At = 247;
constexpr std::size_t kLeastHeader = 227;  // of 1.0 to 1.2
constexpr std::size_t kLeastHeader13 = 235;
constexpr std::size_t kLeastHeader14 = 375;
constexpr std::size_t kFlagsAt = 15;  // of a point

// Of one point format: its least record length, where its GPS time stands (0: it has none), and
// which of its flags withholds a point.
struct PointFormat {
  std::size_t length = 0;
  std::size_t time_at = 0;
  std::uint8_t withheld = 0;
};
constexpr std::uint8_t kWithheld = 0x80;   // beside the class, in five bits
constexpr std::uint8_t kWithheld6 = 0x04;  // from format 6 on
constexpr std::array<PointFormat, 11> kFormats = {{{20, 0, kWithheld},
                                                   {28, 20, kWithheld},
                                                   {26, 0, kWithheld},
                                                   {34, 20, kWithheld},
                                                   {57, 20, kWithheld},
                                                   {63, 20, kWithheld},
                                                   {30, 22, kWithheld6},
                                                   {36, 22, kWithheld6},
                                                   {38, 22, kWithheld6},
                                                   {59, 22, kWithheld6},
                                                   {67, 22, kWithheld6}}};

struct LasHeader {
  PointFormat format;
  std::size_t record_length = 0;
  std::uint64_t count = 0;
  std::size_t data_offset = 0;
  LasRecordPlaces records;
  bool has_more = false;  // waveforms or extended records, which may stand behind the points
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
};

Error malformed(const FileBytes& file, std::size_t at, std::string message) {
  return file.error(ErrorCode::kMalformedHeader, std::move(message), at_byte(at));
}

Error too_short(const FileBytes& file, std::uint64_t expected) {
  return file.error(ErrorCode::kTruncatedScan,
                    concat("found ", file.bytes.size(), " bytes, the header requires ", expected),
                    at_byte(file.bytes.size()));
}

// Version and point format; says how to convert what is compressed.
Result<PointFormat> point_format(const FileBytes& file) {
  const auto major = read_at<std::uint8_t>(file.bytes, kVersionAt);
  const auto minor = read_at<std::uint8_t>(file.bytes, kVersionAt + 1);
  const auto id = read_at<std::uint8_t>(file.bytes, kFormatAt);
  // LASzip marks its files in the upper bits of the point format.
  if ((id & 0xC0U) != 0) {
    return file.error(ErrorCode::kUnsupportedFormat,
                      "LAZ is not read; convert it with `laszip -i in.laz -o out.las` or "
                      "`pdal translate in.laz out.las`",
                      at_byte(kFormatAt));
  }
  if (major != 1 || minor > 4) {
    return file.error(
        ErrorCode::kUnsupportedFormat,
        concat("found LAS ", major, ".", minor,
               ", expected 1.0 to 1.4; convert it with `pdal translate in.las out.pcd`"),
        at_byte(kVersionAt));
  }
  if (id >= kFormats.size()) {
    return malformed(file, kFormatAt, concat("found point format ", id, ", expected 0 to 10"));
  }
  PointFormat format = kFormats[id];
  if (minor == 0) format.withheld = 0;  // 1.1 brought the flag
  return format;
}

Result<void> read_scales(const FileBytes& file, LasHeader& header) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t place = 8 * static_cast<std::size_t>(axis);
    header.scale[axis] = read_at<double>(file.bytes, kScaleAt + place);
    header.offset_m[axis] = read_at<double>(file.bytes, kOffsetAt + place);
  }
  if (!header.scale.allFinite() || header.scale.minCoeff() <= 0.0) {
    return malformed(file, kScaleAt, "a scale is not above 0");
  }
  if (!header.offset_m.allFinite()) return malformed(file, kOffsetAt, "an offset is not finite");
  return {};
}

void read_records(const FileBytes& file, std::size_t header_size, LasHeader& header) {
  const auto minor = read_at<std::uint8_t>(file.bytes, kVersionAt + 1);
  header.records = {header_size, read_at<std::uint32_t>(file.bytes, kRecordsAt), header.data_offset,
                    0, 0};
  if (minor >= 3 && header_size >= kLeastHeader13) {
    header.has_more = read_at<std::uint64_t>(file.bytes, kWaveformsAt) != 0;
  }
  if (minor < 4) return;
  header.records.extended_first = read_at<std::uint64_t>(file.bytes, kExtendedAt);
  header.records.extended_count = read_at<std::uint32_t>(file.bytes, kExtendedCountAt);
  header.has_more = header.has_more || header.records.extended_count > 0;
}

Result<LasHeader> parse_header(const FileBytes& file) {
  if (file.bytes.size() <= kFormatAt) return too_short(file, kLeastHeader);
  SIGHTLINE_ASSIGN(const PointFormat format, point_format(file));
  if (file.bytes.size() < kLeastHeader) return too_short(file, kLeastHeader);
  LasHeader header;
  header.format = format;
  header.record_length = read_at<std::uint16_t>(file.bytes, kRecordLengthAt);
  header.data_offset = read_at<std::uint32_t>(file.bytes, kDataOffsetAt);
  const std::size_t header_size = read_at<std::uint16_t>(file.bytes, kHeaderSizeAt);
  const bool is_14 = read_at<std::uint8_t>(file.bytes, kVersionAt + 1) == 4;
  if (header_size < (is_14 ? kLeastHeader14 : kLeastHeader) || header.data_offset < header_size) {
    return malformed(file, kHeaderSizeAt, "the header or data offset is smaller than LAS allows");
  }
  if (file.bytes.size() < header.data_offset) return too_short(file, header.data_offset);
  if (header.record_length < header.format.length) {
    return malformed(file, kRecordLengthAt,
                     concat("found records of ", header.record_length, " bytes, expected at least ",
                            header.format.length));
  }
  // 1.4 may leave the older, shorter count at 0, and careless writers of 1.4 the newer one.
  header.count = is_14 ? read_at<std::uint64_t>(file.bytes, kCount14At) : 0;
  if (header.count == 0) header.count = read_at<std::uint32_t>(file.bytes, kCountAt);
  read_records(file, header_size, header);
  SIGHTLINE_TRY(read_scales(file, header));
  return header;
}

// Whether the points are as many as the header says: all there, and none behind them.
Result<void> check_size(const FileBytes& file, const LasHeader& header) {
  if (header.count == 0) {
    return file.error(ErrorCode::kEmptyScan, "the header has a count of 0 points",
                      at_byte(kCountAt));
  }
  const std::uint64_t room = (file.bytes.size() - header.data_offset) / header.record_length;
  if (header.count > room) {
    return file.error(ErrorCode::kTruncatedScan,
                      concat("found room for ", room, " points, the header has ", header.count),
                      at_byte(file.bytes.size()));
  }
  const std::size_t end = header.data_offset + header.count * header.record_length;
  if (header.has_more || is_padding(file.text().substr(end))) return {};
  return malformed(file, end,
                   concat("found ", file.bytes.size() - end, " bytes after the ", header.count,
                          " points of the header"));
}

}  // namespace

Result<PointCloudFile> parse_las(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const LasHeader header, parse_header(file));
  SIGHTLINE_TRY(check_reference(file, header.records));
  SIGHTLINE_TRY(check_size(file, header));
  PointCloudFile cloud;
  std::vector<double> times;
  for (std::uint64_t i = 0; i < header.count; ++i) {
    const std::size_t at = header.data_offset + i * header.record_length;
    if ((read_at<std::uint8_t>(file.bytes, at + kFlagsAt) & header.format.withheld) != 0) {
      ++cloud.withheld_count;
      continue;
    }
    Eigen::Vector3d point_m;
    for (int axis = 0; axis < 3; ++axis) {
      const auto units = read_at<std::int32_t>(file.bytes, at + 4 * static_cast<std::size_t>(axis));
      point_m[axis] = units * header.scale[axis] + header.offset_m[axis];
    }
    const auto intensity = static_cast<float>(read_at<std::uint16_t>(file.bytes, at + 12));
    if (!add_point(cloud, point_m, intensity) || header.format.time_at == 0) continue;
    times.push_back(read_at<double>(file.bytes, at + header.format.time_at));
  }
  SIGHTLINE_TRY(check_extent(file, cloud, header.scale));
  constexpr double kGpsUnit_ns = 1e9;
  if (header.format.time_at != 0) set_point_times(times, cloud, kGpsUnit_ns);
  return cloud;
}

}  // namespace sightline
