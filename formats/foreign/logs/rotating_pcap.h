#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// What the data packets of a LiDAR with a turning head say: blocks of an azimuth and the returns of
// all lasers. One kind of packet each; `bytes` is a datagram that is_data().
class RotatingLidar {
 public:
  virtual ~RotatingLidar() = default;

  // "Velodyne", for messages.
  [[nodiscard]] virtual std::string maker() const = 0;
  // Whether a datagram is one of its data packets, by its size and what stands first.
  [[nodiscard]] virtual bool is_data(std::span<const std::byte> datagram) const = 0;
  // Bytes of a data packet that are read; datagrams may be longer.
  [[nodiscard]] virtual std::size_t packet_size() const = 0;
  // Whether a data packet holds what it must, and is of the model that is read here. Errors without
  // a place: malformed-header, unsupported-format (says how to convert it).
  [[nodiscard]] virtual Result<void> check(std::span<const std::byte> bytes) const = 0;
  // Which sensor: packets of one drive have one.
  [[nodiscard]] virtual int model(std::span<const std::byte> bytes) const = 0;

  [[nodiscard]] virtual std::size_t block_count() const = 0;
  // Hundredths of a degree, clockwise from above, 0 .. 35999.
  [[nodiscard]] virtual unsigned azimuth_cdeg(std::span<const std::byte> bytes,
                                              std::size_t block) const = 0;
  // Of the packet, ns. Absolute where it has a date, else since the full hour, below an hour.
  [[nodiscard]] virtual std::int64_t time_ns(std::span<const std::byte> bytes) const = 0;
  [[nodiscard]] virtual bool has_date() const = 0;
  // When the block's first laser fired, ns after the packet's time.
  [[nodiscard]] virtual std::int64_t block_offset_ns(std::span<const std::byte> bytes,
                                                     std::size_t block) const = 0;
  // Adds the returns of one block; time_offset_ns is that of their firing, with the packet's own
  // time at `base_ns`. A distance of 0 is no return (zero_count), nor is the second of two equal
  // ones of a mode that gives two.
  virtual void append_block(std::span<const std::byte> bytes, std::size_t block,
                            std::int64_t base_ns, PointCloudFile& cloud) const = 0;

  // What decides where points lie beside the packets, for digests; empty: nothing.
  [[nodiscard]] virtual std::vector<std::byte> calibration() const { return {}; }
  // What was assumed of the sensor, for the person who brought the file.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }
};

// Absolute times of a LiDAR's packets. From microseconds since the hour: the hour is the one that
// brings the first time nearest to `near_ns`; from there on the sensor's clock counts alone,
// through full hours. From a date: as it is; one before 2005 is of a clock that was not set, and
// counts from `near_ns` at the first packet.
class PacketClock {
 public:
  explicit PacketClock(bool has_date) : has_date_(has_date) {}
  std::int64_t absolute_ns(std::int64_t packet_ns, std::int64_t near_ns);
  [[nodiscard]] bool is_shifted() const { return shift_ns_.value_or(0) != 0; }

 private:
  std::int64_t of_hour(std::int64_t within_ns, std::int64_t near_ns);

  bool has_date_;
  std::optional<std::int64_t> now_ns_;
  std::optional<std::int64_t> shift_ns_;
};

// The whole revolutions of a turning LiDAR in a pcap. Errors: those of PcapReader,
// malformed-header (no data packet), unsupported-format (another model), time-runs-backwards,
// drive-too-short (no whole revolution).
Result<std::shared_ptr<const ScanContainer>> open_rotating_pcap(
    const std::filesystem::path& path, std::unique_ptr<const RotatingLidar> lidar);

}  // namespace sightline
