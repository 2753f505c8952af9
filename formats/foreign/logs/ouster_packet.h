#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/ouster_metadata.h"
#include "formats/geometry.h"

// Lidar data packets of Ouster's sensors as the Software User Manual describes them: a header,
// columns of one time and one turn of the head, a footer. A column has a return or two of every
// beam.

namespace sightline {

// Where things lie in the packets of one profile.
struct OusterLayout {
  struct Return {
    std::size_t range_at = 0;  // in its pixel, bytes
    std::uint32_t range_mask = 0;
    std::size_t range_size = 4;
    double tick_m = 0.001;
    std::size_t reflectivity_at = 0;
  };
  std::string profile;  // LEGACY, RNG19_RFL8_SIG16_NIR16, ...
  bool is_legacy = false;
  std::size_t pixel_size = 0;
  std::vector<Return> returns;
};

// The profiles that are read, one space apart, for messages.
std::string ouster_profile_names();

class OusterPackets {
 public:
  // Errors without a file: missing-field (the metadata lacks columns, azimuths or transforms),
  // unsupported-format (another profile; says how to convert it), bad-value (packets longer than
  // UDP allows).
  static Result<OusterPackets> of(const OusterMetadata& metadata);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t column_count() const { return metadata_.columns_per_packet; }
  [[nodiscard]] std::size_t columns_per_frame() const { return metadata_.columns_per_frame; }
  // Packets of a frame, from the first column to the last one that is sent.
  [[nodiscard]] std::size_t packets_per_frame() const { return packets_per_frame_; }

  // Of the right size, and lidar data as far as that is said. The others below need it.
  [[nodiscard]] bool is_data(std::span<const std::byte> datagram) const;
  [[nodiscard]] std::uint16_t frame_id(std::span<const std::byte> packet) const;

  // Of one column. Whether it was measured, and belongs to the packet's frame.
  [[nodiscard]] bool is_valid(std::span<const std::byte> packet, std::size_t column) const;
  [[nodiscard]] std::size_t measurement_id(std::span<const std::byte> packet,
                                           std::size_t column) const;
  // By the sensor's clock; at most 2^62.
  [[nodiscard]] std::int64_t time_ns(std::span<const std::byte> packet, std::size_t column) const;

  // Adds the returns of a valid column, which was measured `time_offset_ns` after the scan's stamp.
  // Axes: the sensor frame of the manual, x forward, z up. Intensity: reflectivity, 0 .. 255. A
  // range of 0 is no return (zero_count), nor is a second one equal to the first.
  void append_column(std::span<const std::byte> packet, std::size_t column,
                     std::int32_t time_offset_ns, PointCloudFile& cloud) const;

  // All that decides where points lie, for digests.
  [[nodiscard]] std::vector<std::byte> calibration() const;

 private:
  OusterPackets(OusterMetadata metadata, OusterLayout layout);
  [[nodiscard]] std::size_t column_at(std::size_t column) const;

  OusterMetadata metadata_;
  OusterLayout layout_;
  Eigen::Matrix3d R_sensor_lidar_;
  Eigen::Vector3d t_sensor_lidar_m_;
  std::size_t column_size_ = 0;
  std::size_t size_ = 0;
  std::size_t packets_per_frame_ = 0;
};

}  // namespace sightline
