#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/foreign/logs/rotating_lidar.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Where one revolution of a turning LiDAR lies in a pcap: from the block at which the azimuth
// falls back to the block before the next fall.
struct Revolution {
  std::uint64_t offset = 0;      // of the record of its first packet, bytes
  std::size_t packet_count = 0;  // data packets, none of them twice
  std::size_t first_block = 0;   // in its first packet
  std::size_t end_block = 0;     // in its last packet, behind its last block
  std::int64_t first_ns = 0;     // time of its first packet, of the sensor's clock
};

struct RevolutionIndex {
  std::vector<Revolution> revolutions;
  std::vector<ContainedScan> scans;  // one each; content: as begin_scan and store_packet put it
  std::vector<std::string> warnings;
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

// How a packet lies among the bytes of a scan: its absolute time, then what is read of its datagram
// (packet_size() of them). The LiDAR's calibration stands before the first.
ByteWriter begin_scan(const RotatingLidar& lidar);
void store_packet(const RotatingLidar& lidar, std::int64_t time_ns,
                  std::span<const std::byte> datagram, ByteWriter& bytes);
std::size_t stored_size(const RotatingLidar& lidar);

// Walks through the file once, holding one revolution. What stands before the first fall, behind
// the last one or around a gap of more than 10 ms is no whole revolution; a packet with the time of
// the one before was captured twice. Errors: those of PcapReader, malformed-header (no data
// packet), unsupported-format (another model), time-runs-backwards, drive-too-short (no whole
// revolution).
Result<RevolutionIndex> find_revolutions(const std::filesystem::path& path,
                                         const RotatingLidar& lidar);

}  // namespace sightline
