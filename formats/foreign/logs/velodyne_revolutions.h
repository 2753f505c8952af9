#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Where one revolution of a Velodyne sensor lies in a pcap: from the block at which the azimuth
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
  std::vector<ContainedScan> scans;  // one each; content: of the packets as store_packet puts them
  std::vector<std::string> warnings;
};

// Absolute times from microseconds since the hour. The hour is the one that brings the first time
// nearest to `near_ns`; from there on the sensor's clock counts alone, through full hours.
class HourClock {
 public:
  std::int64_t absolute_ns(std::uint32_t hour_us, std::int64_t near_ns);

 private:
  std::optional<std::int64_t> now_ns_;
};

// How a packet lies among the bytes of a scan: its absolute time, then its datagram.
void store_packet(std::int64_t time_ns, std::span<const std::byte> datagram, ByteWriter& bytes);

// Walks through the file once, holding one revolution. What stands before the first fall, behind
// the last one or around a gap of more than 10 ms is no whole revolution; a packet with the time of
// the one before was captured twice. Errors: those of PcapReader, malformed-header (no data
// packet), unsupported-format (another model), time-runs-backwards, drive-too-short (no whole
// revolution).
Result<RevolutionIndex> find_revolutions(const std::filesystem::path& path);

}  // namespace sightline
