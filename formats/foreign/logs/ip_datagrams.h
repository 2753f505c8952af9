#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

// What UDP over IPv4 carries, put together where it came in fragments (RFC 791): a datagram longer
// than a frame of the network, as Ouster's are, comes so.
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

}  // namespace sightline
