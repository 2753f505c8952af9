#pragma once

#include "formats/foreign/logs/rotating_lidar.h"

namespace sightline {

// The packets of velodyne_packet.h. Axes: x along azimuth 0, y left, z up.
class VelodyneLidar : public RotatingLidar {
 public:
  [[nodiscard]] std::string maker() const override { return "Velodyne"; }
  [[nodiscard]] bool is_data(std::span<const std::byte> datagram) const override;
  [[nodiscard]] std::size_t packet_size() const override;
  [[nodiscard]] Result<void> check(std::span<const std::byte> bytes) const override;
  [[nodiscard]] int model(std::span<const std::byte> bytes) const override;
  [[nodiscard]] std::size_t block_count() const override;
  [[nodiscard]] unsigned azimuth_cdeg(std::span<const std::byte> bytes,
                                      std::size_t block) const override;
  [[nodiscard]] std::int64_t time_ns(std::span<const std::byte> bytes) const override;
  [[nodiscard]] bool has_date() const override { return false; }
  [[nodiscard]] std::int64_t block_offset_ns(std::span<const std::byte> bytes,
                                             std::size_t block) const override;
  void append_block(std::span<const std::byte> bytes, std::size_t block, std::int64_t base_ns,
                    PointCloudFile& cloud) const override;
};

}  // namespace sightline
