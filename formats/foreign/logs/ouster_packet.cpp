#include "formats/foreign/logs/ouster_packet.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include "formats/base/bytes.h"
#include "formats/base/portable_math.h"
#include "formats/base/units.h"
#include "formats/foreign/text/file_bytes.h"

namespace sightline {
namespace {

// Legacy packets have no header; each column ends with a word that says whether it is whole. The
// others have a header and a footer of 32 bytes each, and say it in the column's header.
constexpr std::size_t kHeader = 32;
constexpr std::size_t kFooter = 32;
constexpr std::size_t kLegacyColumnHeader = 16;
constexpr std::size_t kLegacyColumnFooter = 4;
constexpr std::size_t kColumnHeader = 12;
constexpr std::uint32_t kLegacyValid = 0xffffffff;
constexpr std::uint16_t kLidarPacket = 1;
constexpr std::size_t kLargestDatagram = 65507;
constexpr std::uint32_t k15Bits = 0x7fff;
constexpr std::uint32_t k19Bits = 0x7ffff;
constexpr std::uint32_t k20Bits = 0xfffff;

// Software User Manual, "Lidar Data Format".
const std::array<OusterLayout, 4>& layouts() {
  static const std::array<OusterLayout, 4> all = {{
      {"LEGACY", true, 12, {{0, k20Bits, 4, 0.001, 4}}},
      {"RNG19_RFL8_SIG16_NIR16", false, 12, {{0, k19Bits, 4, 0.001, 4}}},
      {"RNG19_RFL8_SIG16_NIR16_DUAL",
       false,
       16,
       {{0, k19Bits, 4, 0.001, 3}, {4, k19Bits, 4, 0.001, 7}}},
      {"RNG15_RFL8_NIR8", false, 4, {{0, k15Bits, 2, 0.008, 2}}},
  }};
  return all;
}

std::uint32_t range_ticks(std::span<const std::byte> bytes, std::size_t pixel_at,
                          const OusterLayout::Return& part) {
  const std::size_t at = pixel_at + part.range_at;
  const std::uint32_t word =
      part.range_size == 2 ? read_at<std::uint16_t>(bytes, at) : read_at<std::uint32_t>(bytes, at);
  return word & part.range_mask;
}

Result<OusterLayout> layout_of(const std::string& profile) {
  for (const OusterLayout& layout : layouts()) {
    if (layout.profile == profile) return layout;
  }
  return Error{ErrorCode::kUnsupportedFormat,
               "found the profile " + profile + ", expected one of " + ouster_profile_names() +
                   "; convert it with `ouster-cli source CAPTURE save scans.bag`"};
}

}  // namespace

std::string ouster_profile_names() {
  std::string names;
  for (const OusterLayout& layout : layouts()) {
    names += (names.empty() ? "" : " ") + layout.profile;
  }
  return names;
}

OusterPackets::OusterPackets(OusterMetadata metadata, OusterLayout layout)
    : metadata_(std::move(metadata)), layout_(std::move(layout)) {
  constexpr double kMillimetre_m = 0.001;
  const Eigen::Matrix4d& to_sensor = *metadata_.lidar_to_sensor;
  R_sensor_lidar_ = to_sensor.topLeftCorner<3, 3>();
  t_sensor_lidar_m_ = kMillimetre_m * to_sensor.topRightCorner<3, 1>();
  const std::size_t pixels = metadata_.altitudes_deg.size() * layout_.pixel_size;
  column_size_ = layout_.is_legacy ? kLegacyColumnHeader + pixels + kLegacyColumnFooter
                                   : kColumnHeader + pixels;
  size_ = metadata_.columns_per_packet * column_size_ + (layout_.is_legacy ? 0 : kHeader + kFooter);
  // A window may go through column 0.
  const std::size_t columns = metadata_.columns_per_frame;
  const std::size_t step = metadata_.columns_per_packet;
  const std::size_t first = metadata_.first_column / step;
  const std::size_t last = metadata_.last_column / step;
  const std::size_t all = (columns + step - 1) / step;
  packets_per_frame_ = std::min(all, (last >= first ? last : last + all) - first + 1);
}

Result<OusterPackets> OusterPackets::of(const OusterMetadata& metadata) {
  const auto lacks = [](const std::string& what) {
    return Error{ErrorCode::kMissingField, "the metadata lacks " + what};
  };
  if (metadata.azimuths_deg.empty()) return lacks("beam_azimuth_angles");
  if (metadata.columns_per_frame == 0) return lacks("columns_per_frame");
  if (!metadata.beam_radius_mm) return lacks("lidar_origin_to_beam_origin_mm");
  if (!metadata.lidar_to_sensor) return lacks("lidar_to_sensor_transform");
  Pose to_sensor = Pose::Identity();
  to_sensor.linear() = metadata.lidar_to_sensor->topLeftCorner<3, 3>();
  if (!is_rigid(to_sensor)) {
    return Error{ErrorCode::kBadValue, "lidar_to_sensor_transform is no rotation and translation"};
  }
  SIGHTLINE_ASSIGN(OusterLayout layout, layout_of(metadata.profile));
  OusterPackets packets(metadata, std::move(layout));
  if (packets.size_ <= kLargestDatagram) return packets;
  return Error{ErrorCode::kBadValue,
               "packets of " + std::to_string(packets.size_) + " bytes are longer than UDP allows"};
}

bool OusterPackets::is_data(std::span<const std::byte> datagram) const {
  if (datagram.size() != size_) return false;
  return layout_.is_legacy || read_at<std::uint16_t>(datagram, 0) == kLidarPacket;
}

std::size_t OusterPackets::column_at(std::size_t column) const {
  return (layout_.is_legacy ? 0 : kHeader) + column * column_size_;
}

std::uint16_t OusterPackets::frame_id(std::span<const std::byte> packet) const {
  return read_at<std::uint16_t>(packet, layout_.is_legacy ? 10 : 2);
}

bool OusterPackets::is_valid(std::span<const std::byte> packet, std::size_t column) const {
  const std::size_t at = column_at(column);
  if (measurement_id(packet, column) >= metadata_.columns_per_frame) return false;
  if (!layout_.is_legacy) return (read_at<std::uint16_t>(packet, at + 10) & 1U) != 0;
  return read_at<std::uint16_t>(packet, at + 10) == frame_id(packet) &&
         read_at<std::uint32_t>(packet, at + column_size_ - kLegacyColumnFooter) == kLegacyValid;
}

std::size_t OusterPackets::measurement_id(std::span<const std::byte> packet,
                                          std::size_t column) const {
  return read_at<std::uint16_t>(packet, column_at(column) + 8);
}

std::int64_t OusterPackets::time_ns(std::span<const std::byte> packet, std::size_t column) const {
  constexpr std::uint64_t kMost_ns = std::uint64_t{1} << 62U;
  return static_cast<std::int64_t>(
      std::min(kMost_ns, read_at<std::uint64_t>(packet, column_at(column))));
}

// Software User Manual, "Lidar Range to XYZ": the beam leaves a point that turns with the head, and
// the range counts from the axis along the way of the light.
void OusterPackets::append_column(std::span<const std::byte> packet, std::size_t column,
                                  std::int32_t time_offset_ns, PointCloudFile& cloud) const {
  constexpr double kMillimetre_m = 0.001;
  const double turn = static_cast<double>(measurement_id(packet, column)) /
                      static_cast<double>(metadata_.columns_per_frame);
  const double encoder_rad = 2.0 * std::numbers::pi * (1.0 - turn);
  const double radius_m = kMillimetre_m * *metadata_.beam_radius_mm;
  const double height_m = kMillimetre_m * metadata_.beam_height_mm;
  const double lead_m = height_m == 0.0 ? radius_m : portable_hypot(radius_m, height_m);
  const SinCos encoder = portable_sin_cos(encoder_rad);
  const Eigen::Vector3d origin_m(radius_m * encoder.cos, radius_m * encoder.sin, height_m);
  const std::size_t first_pixel_at =
      column_at(column) + (layout_.is_legacy ? kLegacyColumnHeader : kColumnHeader);
  for (std::size_t beam = 0; beam < metadata_.altitudes_deg.size(); ++beam) {
    const std::size_t pixel_at = first_pixel_at + beam * layout_.pixel_size;
    const Eigen::Vector3d direction =
        direction_of(encoder_rad - kRadPerDeg * metadata_.azimuths_deg[beam],
                     kRadPerDeg * metadata_.altitudes_deg[beam]);
    std::uint32_t before = 0;
    for (const OusterLayout::Return& part : layout_.returns) {
      const std::uint32_t ticks = range_ticks(packet, pixel_at, part);
      if (ticks == 0 || ticks == before) {
        ++cloud.zero_count;
        continue;
      }
      before = ticks;
      const Eigen::Vector3d p_lidar_m = (part.tick_m * ticks - lead_m) * direction + origin_m;
      const auto reflectivity =
          static_cast<float>(std::to_integer<int>(packet[pixel_at + part.reflectivity_at]));
      if (add_point(cloud, R_sensor_lidar_ * p_lidar_m + t_sensor_lidar_m_, reflectivity)) {
        cloud.time_offset_ns.push_back(time_offset_ns);
      }
    }
  }
}

std::vector<std::byte> OusterPackets::calibration() const {
  ByteWriter bytes;
  bytes.put_string(metadata_.profile);
  bytes.put<std::uint64_t>(metadata_.columns_per_frame);
  bytes.put_array(metadata_.altitudes_deg);
  bytes.put_array(metadata_.azimuths_deg);
  bytes.put(*metadata_.beam_radius_mm);
  bytes.put(metadata_.beam_height_mm);
  for (const double value : metadata_.lidar_to_sensor->reshaped()) bytes.put(value);
  return bytes.take();
}

}  // namespace sightline
