#include "formats/foreign/logs/pcap_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

// The classic capture file: 24 bytes of header, then records of 16 bytes and a frame each, in the
// byte order of the machine that wrote them, which the magic number tells.

namespace sightline {
namespace {

constexpr std::size_t kHeaderSize = 24;
constexpr std::size_t kRecordHeaderSize = 16;
constexpr std::uint32_t kMostFrame = 1U << 18U;  // libpcap's own limit
constexpr std::uint32_t kMagicMicroseconds = 0xa1b2c3d4;
constexpr std::uint32_t kMagicNanoseconds = 0xa1b23c4d;

// Link types and how many bytes stand before the IP header.
constexpr std::array<std::pair<std::uint32_t, std::size_t>, 4> kLinks = {
    {{0, 4}, {1, 14}, {101, 0}, {113, 16}}};

std::uint32_t swapped(std::uint32_t value) {
  return (value >> 24U) | ((value >> 8U) & 0xff00U) | ((value << 8U) & 0xff0000U) | (value << 24U);
}

std::uint32_t little(const char* bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::size_t big16(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::size_t>(bytes[at]) << 8U |
         std::to_integer<std::size_t>(bytes[at + 1]);
}

std::optional<std::size_t> link_size(std::uint32_t link_type) {
  for (const auto& [type, size] : kLinks) {
    if (type == link_type) return size;
  }
  return std::nullopt;
}

// The payload of an IPv4 UDP frame that was captured whole and in one piece; empty for any other.
std::span<const std::byte> datagram_of(std::span<const std::byte> frame, std::size_t link) {
  constexpr std::size_t kIpHeader = 20;
  constexpr std::size_t kUdpHeader = 8;
  constexpr std::size_t kVlanTag = 4;
  constexpr std::size_t kVlan = 0x8100;
  constexpr std::size_t kEthernet = 14;
  if (link == kEthernet && frame.size() > kEthernet && big16(frame, 12) == kVlan) link += kVlanTag;
  if (frame.size() < link + kIpHeader + kUdpHeader) return {};
  const std::span<const std::byte> ip = frame.subspan(link);
  const auto first = std::to_integer<unsigned>(ip[0]);
  const std::size_t ip_header = 4U * (first & 15U);
  const bool is_whole_udp = first >> 4U == 4U && ip[9] == std::byte{17} &&
                            (big16(ip, 6) & 0x3fffU) == 0 && ip_header >= kIpHeader;
  if (!is_whole_udp || ip.size() < ip_header + kUdpHeader) return {};
  const std::size_t length = big16(ip, ip_header + 4);
  if (length < kUdpHeader || ip.size() < ip_header + length) return {};
  return ip.subspan(ip_header + kUdpHeader, length - kUdpHeader);
}

}  // namespace

bool is_pcap(std::string_view signature) {
  if (signature.size() < sizeof(std::uint32_t)) return false;
  const std::uint32_t magic = little(signature.data());
  return magic == kMagicMicroseconds || magic == kMagicNanoseconds ||
         swapped(magic) == kMagicMicroseconds || swapped(magic) == kMagicNanoseconds;
}

std::uint32_t PcapReader::number(const char* bytes) const {
  return is_swapped_ ? swapped(little(bytes)) : little(bytes);
}

Error PcapReader::error(ErrorCode code, std::string message) const {
  return {code, std::move(message), path_.string(), "byte " + std::to_string(offset_)};
}

Result<PcapReader> PcapReader::open(const std::filesystem::path& path) {
  PcapReader reader;
  reader.path_ = path;
  reader.file_.open(path, std::ios::binary);
  if (!reader.file_) return reader.error(ErrorCode::kCannotOpen, "cannot open the file");
  std::array<char, kHeaderSize> header{};
  reader.file_.read(header.data(), header.size());
  if (reader.file_.gcount() != static_cast<std::streamsize>(kHeaderSize)) {
    return reader.error(ErrorCode::kTruncatedScan, "shorter than the header of a pcap");
  }
  const std::string_view text(header.data(), header.size());
  if (!is_pcap(text)) return reader.error(ErrorCode::kMalformedHeader, "expected a pcap");
  const std::uint32_t magic = little(header.data());
  reader.is_swapped_ = magic != kMagicMicroseconds && magic != kMagicNanoseconds;
  reader.tick_ns_ = reader.number(header.data()) == kMagicNanoseconds ? 1 : 1000;
  reader.link_type_ = reader.number(header.data() + 20) & 0xffffU;
  if (!link_size(reader.link_type_)) {
    return reader.error(ErrorCode::kUnsupportedFormat,
                        "found link type " + std::to_string(reader.link_type_) +
                            ", expected Ethernet (1), Linux cooked (113), loopback (0) or raw IP "
                            "(101)");
  }
  reader.offset_ = kHeaderSize;
  return reader;
}

Result<bool> PcapReader::next(PcapPacket& packet) {
  std::array<char, kRecordHeaderSize> header{};
  file_.read(header.data(), header.size());
  if (file_.gcount() == 0) return false;
  if (file_.gcount() != static_cast<std::streamsize>(kRecordHeaderSize)) {
    return error(ErrorCode::kTruncatedScan, "the file ends within the header of a packet");
  }
  const std::uint32_t size = number(header.data() + 8);
  if (size > kMostFrame) {
    return error(ErrorCode::kMalformedHeader, "found a packet of " + std::to_string(size) +
                                                  " bytes, expected at most " +
                                                  std::to_string(kMostFrame));
  }
  std::vector<std::byte> frame(size);
  file_.read(reinterpret_cast<char*>(frame.data()), size);
  if (file_.gcount() != static_cast<std::streamsize>(size)) {
    return error(ErrorCode::kTruncatedScan, "the file ends within a packet");
  }
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  packet.offset = offset_;
  packet.time_ns = number(header.data()) * kSecond_ns + number(header.data() + 4) * tick_ns_;
  const std::span<const std::byte> datagram = datagram_of(frame, *link_size(link_type_));
  packet.datagram.assign(datagram.begin(), datagram.end());
  offset_ += kRecordHeaderSize + size;
  return true;
}

void PcapReader::seek(std::uint64_t offset) {
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(offset));
  offset_ = offset;
}

}  // namespace sightline
