#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/foreign/logs/ouster_packet.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Where one frame of an Ouster sensor lies in a pcap.
struct OusterFrame {
  std::uint64_t offset = 0;  // of the record of its first packet, bytes
  std::uint16_t frame_id = 0;
  std::size_t packet_count = 0;  // none of them twice
  std::int64_t stamp_ns = 0;     // of its earliest column, of the sensor's clock as it is
};

struct OusterFrameIndex {
  std::vector<OusterFrame> frames;
  std::vector<ContainedScan> scans;  // one each; content: of the calibration and the packets
  std::vector<std::string> warnings;
};

// The packets of one frame, none of them twice.
class OusterFramePackets {
 public:
  explicit OusterFramePackets(const OusterPackets& packets);

  // False: one with the same columns is there already, or its columns are no frame's.
  bool add(std::span<const std::byte> packet);
  [[nodiscard]] std::size_t count() const { return count_; }
  // The calibration, then the packets.
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  const OusterPackets* packets_;
  std::vector<bool> is_there_;
  std::size_t count_ = 0;
  std::vector<std::byte> bytes_;
};

// Walks through the file once, holding one frame. A frame of which more than a tenth of the packets
// is missing, whose columns span over a second or which none of them measured is left out and
// counted. Stamps are the sensor's; where its clock counts from its start (before 2005), from when
// the first packet was captured. Errors: those of PcapReader, mismatched-inputs (columns that no
// frame has), time-runs-backwards, drive-too-short (no frame).
Result<OusterFrameIndex> find_ouster_frames(const std::filesystem::path& path,
                                            const OusterPackets& packets);

}  // namespace sightline
