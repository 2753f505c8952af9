#include <array>
#include <cstring>

#include "formats/foreign/clouds/las_reference.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"

// LAS 1.0 to 1.4 (ASPRS): a public header block, variable length records of which those of the
// reference system matter, and point records of fixed length. All point formats begin with x, y, z
// (int32, scaled) and intensity; they differ in where the GPS time stands, if there is one, and in
// which bit says that a point is withheld: deleted, but for its bytes.

namespace sightline {
namespace {

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
                    "found " + std::to_string(file.bytes.size()) + " bytes, the header asks for " +
                        std::to_string(expected),
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
    return file.error(ErrorCode::kUnsupportedFormat,
                      "found LAS " + std::to_string(major) + "." + std::to_string(minor) +
                          ", expected 1.0 to 1.4; convert it with `pdal translate in.las out.pcd`",
                      at_byte(kVersionAt));
  }
  if (id >= kFormats.size()) {
    return malformed(file, kFormatAt,
                     "found point format " + std::to_string(id) + ", expected 0 to 10");
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
    return malformed(file, kHeaderSizeAt, "a header or data offset smaller than LAS has");
  }
  if (file.bytes.size() < header.data_offset) return too_short(file, header.data_offset);
  if (header.record_length < header.format.length) {
    return malformed(file, kRecordLengthAt,
                     "found records of " + std::to_string(header.record_length) +
                         " bytes, expected at least " + std::to_string(header.format.length));
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
    return file.error(ErrorCode::kEmptyScan, "the header says that there are no points",
                      at_byte(kCountAt));
  }
  const std::uint64_t room = (file.bytes.size() - header.data_offset) / header.record_length;
  if (header.count > room) {
    return file.error(ErrorCode::kTruncatedScan,
                      "found room for " + std::to_string(room) + " points, the header speaks of " +
                          std::to_string(header.count),
                      at_byte(file.bytes.size()));
  }
  const std::size_t end = header.data_offset + header.count * header.record_length;
  if (header.has_more || is_padding(file.text().substr(end))) return {};
  return malformed(file, end,
                   "found " + std::to_string(file.bytes.size() - end) + " bytes behind the " +
                       std::to_string(header.count) + " points that the header speaks of");
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
