#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// What UDP over IPv4 carries, put together from fragments (RFC 791), as long datagrams come.
class IpDatagrams {
 public:
  struct Datagram {
    std::vector<std::byte> payload;  // empty: the frame completes none
    std::uint64_t offset = 0;        // of the record of its first fragment in time
  };

  // What `frame`, whose record lies at `offset`, completes. `link`: bytes before the IP header.
  // Frames of other protocols and those captured in part complete nothing.
  Datagram add(std::span<const std::byte> frame, std::size_t link, std::uint64_t offset);

  // Forgets the fragments that wait for others.
  void clear() { open_.clear(); }

 private:
  // A datagram of which fragments are missing.
  struct Open {
    std::vector<std::byte> key;  // addresses and identification
    std::vector<std::byte> bytes;
    std::vector<bool> is_there;  // of each 8 bytes
    bool has_end = false;        // the last fragment gave the length
    std::uint64_t offset = 0;
    std::uint64_t serial = 0;
  };

  Open& open_of(std::span<const std::byte> ip, std::uint64_t offset);
  Datagram add_fragment(std::span<const std::byte> ip, std::size_t ip_header, std::uint64_t offset);

  std::vector<Open> open_;  // the oldest first; at most kMostOpen
  std::uint64_t next_serial_ = 0;
};

// Whether a file that begins like this is a capture: a classic pcap, of either byte order, with
// times in microseconds or nanoseconds, or a pcapng.
bool is_pcap(std::string_view signature);

// One captured packet.
struct PcapPacket {
  std::uint64_t offset = 0;         // of its record in the file, or of its first fragment's
  std::int64_t time_ns = 0;         // by the clock of the machine that captured it
  std::vector<std::byte> datagram;  // what UDP carried; empty where it is no whole UDP over IPv4
};

// Reads packets one after the other. Of a pcapng, those of one section whose interfaces are
// described before the first packet, as dumpcap and Wireshark write it.
class PcapReader {
 public:
  // Errors: cannot-open, malformed-header, unsupported-format (a link type that is not Ethernet,
  // Linux cooked, loopback or raw IP; a pcapng of another kind), truncated-scan (shorter than its
  // header).
  static Result<PcapReader> open(const std::filesystem::path& path);

  // False at the end of the file. Errors: truncated-scan (a packet cut short), malformed-header (a
  // record that is no record), with the byte.
  Result<bool> next(PcapPacket& packet);

  // Goes on with the record at `offset`, one that next() gave, and without fragments from before.
  void seek(std::uint64_t offset);

 private:
  PcapReader() = default;
  // A network interface of a pcapng.
  struct Interface {
    std::uint32_t link_type = 0;
    std::uint64_t ticks_per_s = 1'000'000;
  };
  struct Block {
    std::uint32_t type = 0;
    std::vector<char> body;  // without head and tail
  };

  [[nodiscard]] std::uint32_t number(const char* bytes) const;
  [[nodiscard]] Result<void> check_link_type(std::uint32_t link_type) const;
  Result<void> open_classic();
  Result<void> open_sections();
  Result<bool> next_block(Block& block);
  Result<void> take_interface(const Block& block);
  Result<bool> next_classic(PcapPacket& packet);
  Result<bool> next_of_section(PcapPacket& packet);
  void take_frame(std::span<const std::byte> frame, std::uint32_t link_type, PcapPacket& packet);
  [[nodiscard]] Error error(ErrorCode code, std::string message) const;

  std::filesystem::path path_;
  std::ifstream file_;
  std::uint64_t offset_ = 0;  // of the next record
  std::uint32_t link_type_ = 0;
  bool is_swapped_ = false;
  std::int64_t tick_ns_ = 1000;
  bool is_pcapng_ = false;
  std::vector<Interface> interfaces_;
  IpDatagrams datagrams_;
};

// Calls use(packet) for each packet of a capture, in their order. Errors: those of PcapReader, and
// the first that use() returns.
template <class Use>
Result<void> visit_packets(const std::filesystem::path& path, const Use& use) {
  SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path));
  PcapPacket packet;
  while (true) {
    SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
    if (!more) return {};
    SIGHTLINE_TRY(use(packet));
  }
}

}  // namespace sightline
