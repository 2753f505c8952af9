#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// Whether a file that begins like this is a classic pcap, of either byte order, with times in
// microseconds or nanoseconds. (pcapng is another format.)
bool is_pcap(std::string_view signature);

// One captured packet.
struct PcapPacket {
  std::uint64_t offset = 0;         // of its record in the file
  std::int64_t time_ns = 0;         // by the clock of the machine that captured it
  std::vector<std::byte> datagram;  // what UDP carried; empty where it is no whole UDP over IPv4
};

// Reads packets one after the other.
class PcapReader {
 public:
  // Errors: cannot-open, malformed-header, unsupported-format (a link type that is not Ethernet,
  // Linux cooked, loopback or raw IP), truncated-scan (shorter than its header).
  static Result<PcapReader> open(const std::filesystem::path& path);

  // False at the end of the file. Errors: truncated-scan (a packet cut short), malformed-header (a
  // record that is no record), with the byte.
  Result<bool> next(PcapPacket& packet);

  // Goes on with the record at `offset`, one that next() gave.
  void seek(std::uint64_t offset);

 private:
  PcapReader() = default;
  [[nodiscard]] std::uint32_t number(const char* bytes) const;
  [[nodiscard]] Error error(ErrorCode code, std::string message) const;

  std::filesystem::path path_;
  std::ifstream file_;
  std::uint64_t offset_ = 0;  // of the next record
  std::uint32_t link_type_ = 0;
  bool is_swapped_ = false;
  std::int64_t tick_ns_ = 1000;
};

}  // namespace sightline
