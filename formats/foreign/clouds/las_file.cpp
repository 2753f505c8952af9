#include <array>
#include <cstring>

#include "formats/foreign/clouds/cloud_parsers.h"
#include "formats/foreign/clouds/point_times.h"

// LAS 1.0 to 1.4 (ASPRS): a public header block, variable length records that are not needed here,
// and point records of fixed length. All point formats begin with x, y, z (int32, scaled) and
// intensity; they differ in where the GPS time stands, if there is one.

namespace sightline {
namespace {

// Byte offsets in the public header block.
constexpr std::size_t kVersionAt = 24;
constexpr std::size_t kHeaderSizeAt = 94;
constexpr std::size_t kDataOffsetAt = 96;
constexpr std::size_t kFormatAt = 104;
constexpr std::size_t kRecordLengthAt = 105;
constexpr std::size_t kCountAt = 107;
constexpr std::size_t kScaleAt = 131;
constexpr std::size_t kOffsetAt = 155;
constexpr std::size_t kCount14At = 247;
constexpr std::size_t kLeastHeader = 227;    // of 1.0 to 1.2
constexpr std::size_t kLeastHeader14 = 375;  // of 1.4

// Of one point format: its least record length, and where its GPS time stands (0: it has none).
struct PointFormat {
  std::size_t length = 0;
  std::size_t time_at = 0;
};
constexpr std::array<PointFormat, 11> kFormats = {{{20, 0},
                                                   {28, 20},
                                                   {26, 0},
                                                   {34, 20},
                                                   {57, 20},
                                                   {63, 20},
                                                   {30, 22},
                                                   {36, 22},
                                                   {38, 22},
                                                   {59, 22},
                                                   {67, 22}}};

struct LasHeader {
  PointFormat format;
  std::size_t record_length = 0;
  std::uint64_t count = 0;
  std::size_t data_offset = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
};

template <class T>
T read_at(const FileBytes& file, std::size_t at) {
  T value{};
  std::memcpy(&value, file.bytes.data() + at, sizeof value);
  return value;
}

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
  const auto major = read_at<std::uint8_t>(file, kVersionAt);
  const auto minor = read_at<std::uint8_t>(file, kVersionAt + 1);
  const auto id = read_at<std::uint8_t>(file, kFormatAt);
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
  return kFormats[id];
}

Result<void> read_scales(const FileBytes& file, LasHeader& header) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t place = 8 * static_cast<std::size_t>(axis);
    header.scale[axis] = read_at<double>(file, kScaleAt + place);
    header.offset_m[axis] = read_at<double>(file, kOffsetAt + place);
  }
  if (!header.scale.allFinite() || header.scale.minCoeff() <= 0.0) {
    return malformed(file, kScaleAt, "a scale is not above 0");
  }
  if (!header.offset_m.allFinite()) return malformed(file, kOffsetAt, "an offset is not finite");
  return {};
}

Result<LasHeader> parse_header(const FileBytes& file) {
  if (file.bytes.size() <= kFormatAt) return too_short(file, kLeastHeader);
  SIGHTLINE_ASSIGN(const PointFormat format, point_format(file));
  if (file.bytes.size() < kLeastHeader) return too_short(file, kLeastHeader);
  LasHeader header;
  header.format = format;
  header.record_length = read_at<std::uint16_t>(file, kRecordLengthAt);
  header.data_offset = read_at<std::uint32_t>(file, kDataOffsetAt);
  const std::size_t header_size = read_at<std::uint16_t>(file, kHeaderSizeAt);
  const bool is_14 = read_at<std::uint8_t>(file, kVersionAt + 1) == 4;
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
  header.count = is_14 ? read_at<std::uint64_t>(file, kCount14At) : 0;
  if (header.count == 0) header.count = read_at<std::uint32_t>(file, kCountAt);
  SIGHTLINE_TRY(read_scales(file, header));
  return header;
}

}  // namespace

Result<PointCloudFile> parse_las(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const LasHeader header, parse_header(file));
  if (header.count == 0) {
    return file.error(ErrorCode::kEmptyScan, "the header says that there are no points",
                      at_byte(kCountAt));
  }
  // Waveforms and extended records may follow the points, so more bytes say nothing.
  const std::uint64_t room = (file.bytes.size() - header.data_offset) / header.record_length;
  if (header.count > room) {
    return file.error(ErrorCode::kTruncatedScan,
                      "found room for " + std::to_string(room) + " points, the header speaks of " +
                          std::to_string(header.count),
                      at_byte(file.bytes.size()));
  }
  PointCloudFile cloud;
  std::vector<double> times;
  for (std::uint64_t i = 0; i < header.count; ++i) {
    const std::size_t at = header.data_offset + i * header.record_length;
    Eigen::Vector3d point_m;
    for (int axis = 0; axis < 3; ++axis) {
      const auto units = read_at<std::int32_t>(file, at + 4 * static_cast<std::size_t>(axis));
      point_m[axis] = units * header.scale[axis] + header.offset_m[axis];
    }
    const auto intensity = static_cast<float>(read_at<std::uint16_t>(file, at + 12));
    if (!add_point(cloud, point_m, intensity) || header.format.time_at == 0) continue;
    times.push_back(read_at<double>(file, at + header.format.time_at));
  }
  constexpr double kGpsUnit_ns = 1e9;
  if (header.format.time_at != 0) set_point_times(times, cloud, kGpsUnit_ns);
  return cloud;
}

}  // namespace sightline
