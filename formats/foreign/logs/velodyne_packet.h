#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/logs/rotating_pcap.h"

// Data packets of Velodyne's VLP-16 (also the Puck LITE) and HDL-32E, as their manuals describe
// them: 12 blocks of an azimuth and 32 returns, a time, and two bytes that name mode and model.

namespace sightline {

inline constexpr std::size_t kVelodynePacketSize = 1206;
inline constexpr std::size_t kVelodyneBlocks = 12;

enum class VelodyneModel { kHdl32e, kVlp16 };

// One data packet; the bytes are kVelodynePacketSize long.
class VelodynePacket {
 public:
  explicit VelodynePacket(std::span<const std::byte> bytes);

  // Every block begins as it must.
  [[nodiscard]] bool is_valid() const;
  [[nodiscard]] int product_id() const;
  // Nothing: a model that is not decoded here.
  [[nodiscard]] std::optional<VelodyneModel> model() const;
  // Microseconds since the hour began, at the first firing; below 3.6e9.
  [[nodiscard]] std::uint32_t hour_us() const;
  // Hundredths of a degree, clockwise from above, 0 .. 35999.
  [[nodiscard]] unsigned azimuth_cdeg(std::size_t block) const;
  // When the block's first laser fired, ns after the packet's time.
  [[nodiscard]] std::int64_t block_offset_ns(std::size_t block) const;

  // Adds the returns of one block; time_offset_ns counts from the packet's time at `base_ns`. Axes:
  // x along azimuth 0, y left, z up, from the sensor's origin. Intensity 0 .. 255. A distance of 0
  // is no return (zero_count), nor is the second of two equal ones. model() must be known.
  void append_block(std::size_t block, std::int64_t base_ns, PointCloudFile& cloud) const;

 private:
  [[nodiscard]] bool is_dual() const;
  [[nodiscard]] double azimuth_step_cdeg(std::size_t block) const;

  std::span<const std::byte> bytes_;
};

// The whole revolutions of a pcap. Axes as append_block(); errors of open_scan_container.
Result<std::shared_ptr<const ScanContainer>> open_velodyne_pcap(const std::filesystem::path& path);

}  // namespace sightline
