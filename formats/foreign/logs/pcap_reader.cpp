#include "formats/foreign/logs/pcap_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "formats/base/files/regular_file.h"
#include "formats/base/units.h"

// The classic capture file: 24 bytes of header, then records of 16 bytes and a frame each, in the
// byte order of the machine that wrote them, which the magic number shows. A pcapng
// (draft-ietf-opsawg-pcapng): blocks of a type, a length before and behind, and a body.

namespace sightline {
namespace {

constexpr std::size_t kHeaderSize = 24;
constexpr std::size_t kRecordHeaderSize = 16;
constexpr std::uint32_t kMostFrame = 1U << 18U;  // libpcap's own limit
constexpr std::uint32_t kMagicMicroseconds = 0xa1b2c3d4;
constexpr std::uint32_t kMagicNanoseconds = 0xa1b23c4d;
// Of pcapng: the same in both byte orders, and what shows which it is.
constexpr std::uint32_t kSectionHeader = 0x0a0d0d0a;
constexpr std::uint32_t kByteOrder = 0x1a2b3c4d;
constexpr std::uint32_t kInterface = 1;
constexpr std::uint32_t kSimplePacket = 3;
constexpr std::uint32_t kEnhancedPacket = 6;
constexpr std::size_t kBlockFrame = 12;  // type and both lengths

// Link types and how many bytes stand before the IP header.
constexpr std::array<std::pair<std::uint32_t, std::size_t>, 6> kLinks = {
    {{0, 4}, {1, 14}, {101, 0}, {113, 16}, {228, 0}, {276, 20}}};

std::uint32_t swapped(std::uint32_t value) {
  return (value >> 24U) | ((value >> 8U) & 0xff00U) | ((value << 8U) & 0xff0000U) | (value << 24U);
}

std::uint32_t little(const char* bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint64_t padded(std::uint64_t size) { return (size + 3) / 4 * 4; }

std::optional<std::size_t> link_size(std::uint32_t link_type) {
  for (const auto& [type, size] : kLinks) {
    if (type == link_type) return size;
  }
  return std::nullopt;
}

constexpr std::size_t kIpHeader = 20;
constexpr std::size_t kUdpHeader = 8;
constexpr std::size_t kUnit = 8;               // fragments begin at multiples of it
constexpr std::size_t kMostBytes = 1U << 16U;  // of a datagram: its length has 16 bits
// Those of a few sensors that send at once; a lost fragment's datagram leaves when others come.
constexpr std::size_t kMostOpen = 8;
// Identifications come again after 65536 datagrams: what waits longer than this many is lost.
constexpr std::uint64_t kLongestWait = 64;

std::size_t big16(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::size_t>(bytes[at]) << 8U |
         std::to_integer<std::size_t>(bytes[at + 1]);
}

// What stands behind the header of UDP; empty where it is longer than what there is.
std::span<const std::byte> payload_of(std::span<const std::byte> udp) {
  if (udp.size() < kUdpHeader) return {};
  const std::size_t length = big16(udp, 4);
  if (length < kUdpHeader || udp.size() < length) return {};
  return udp.subspan(kUdpHeader, length - kUdpHeader);
}

std::vector<std::byte> copy_of(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

bool is_pcap(std::string_view signature) {
  if (signature.size() < sizeof(std::uint32_t)) return false;
  const std::uint32_t magic = little(signature.data());
  return magic == kMagicMicroseconds || magic == kMagicNanoseconds ||
         swapped(magic) == kMagicMicroseconds || swapped(magic) == kMagicNanoseconds ||
         magic == kSectionHeader;
}

std::uint32_t PcapReader::number(const char* bytes) const {
  return is_swapped_ ? swapped(little(bytes)) : little(bytes);
}

Error PcapReader::error(ErrorCode code, std::string message) const {
  return {code, std::move(message), path_.string(), concat("byte ", offset_)};
}

Result<PcapReader> PcapReader::open(const std::filesystem::path& path) {
  SIGHTLINE_TRY(open_regular_file(path.string()));
  PcapReader reader;
  reader.path_ = path;
  reader.file_.open(path, std::ios::binary);
  if (!reader.file_) return reader.error(ErrorCode::kCannotOpen, "cannot open the file");
  std::array<char, 4> signature{};
  reader.file_.read(signature.data(), signature.size());
  reader.file_.clear();
  reader.file_.seekg(0);
  reader.is_pcapng_ = little(signature.data()) == kSectionHeader;
  if (reader.is_pcapng_) {
    SIGHTLINE_TRY(reader.open_sections());
  } else {
    SIGHTLINE_TRY(reader.open_classic());
  }
  return reader;
}

Result<void> PcapReader::open_classic() {
  std::array<char, kHeaderSize> header{};
  file_.read(header.data(), header.size());
  if (file_.gcount() != static_cast<std::streamsize>(kHeaderSize)) {
    return error(ErrorCode::kTruncatedScan, "shorter than the header of a pcap");
  }
  const std::string_view text(header.data(), header.size());
  if (!is_pcap(text)) return error(ErrorCode::kMalformedHeader, "expected a pcap");
  const std::uint32_t magic = little(header.data());
  is_swapped_ = magic != kMagicMicroseconds && magic != kMagicNanoseconds;
  tick_ns_ = number(header.data()) == kMagicNanoseconds ? 1 : 1000;
  link_type_ = number(header.data() + 20) & 0xffffU;
  offset_ = kHeaderSize;
  return check_link_type(link_type_);
}

Result<void> PcapReader::check_link_type(std::uint32_t link_type) const {
  if (link_size(link_type)) return {};
  return error(
      ErrorCode::kUnsupportedFormat,
      concat("found link type ", link_type,
             ", expected Ethernet (1), Linux cooked (113 or 276), loopback (0) or raw IP (101 "
             "or 228)"));
}

// The head of the section and the interfaces behind it, up to the first packet.
Result<void> PcapReader::open_sections() {
  std::array<char, 12> head{};
  file_.read(head.data(), head.size());
  if (file_.gcount() != static_cast<std::streamsize>(head.size())) {
    return error(ErrorCode::kTruncatedScan, "shorter than the header of a pcapng");
  }
  const std::uint32_t order = little(head.data() + 8);
  is_swapped_ = swapped(order) == kByteOrder;
  if (!is_swapped_ && order != kByteOrder) {
    return error(ErrorCode::kMalformedHeader, "expected the byte order of a pcapng");
  }
  seek(0);
  Block block;
  SIGHTLINE_TRY(next_block(block));
  while (true) {
    const std::uint64_t begin = offset_;
    SIGHTLINE_ASSIGN(const bool more, next_block(block));
    if (!more) return {};
    if (block.type == kEnhancedPacket || block.type == kSimplePacket) {
      seek(begin);
      return {};
    }
    if (block.type != kInterface) continue;  // names, statistics
    SIGHTLINE_TRY(take_interface(block));
  }
}

Result<void> PcapReader::take_interface(const Block& block) {
  if (block.body.size() < 8) {
    return error(ErrorCode::kMalformedHeader, "an interface without a link type");
  }
  Interface interface;
  const std::uint32_t first = number(block.body.data());
  interface.link_type = is_swapped_ ? first >> 16U : first & 0xffffU;
  SIGHTLINE_TRY(check_link_type(interface.link_type));
  // Options: a code and a length of 16 bits, a value; 9 is the resolution of times.
  for (std::size_t at = 8; at + 4 <= block.body.size();) {
    const std::uint32_t option = number(block.body.data() + at);
    const std::uint32_t code = is_swapped_ ? option >> 16U : option & 0xffffU;
    const std::uint32_t size = is_swapped_ ? option & 0xffffU : option >> 16U;
    if (code == 0 || size > block.body.size() - at - 4) break;
    if (code == 9 && size >= 1) {
      const auto exponent = static_cast<unsigned char>(block.body[at + 4]);
      constexpr unsigned kMostDecimals = 9;
      if (exponent > kMostDecimals) {
        return error(ErrorCode::kUnsupportedFormat,
                     "found times finer than nanoseconds, or in powers of two; convert it with "
                     "`editcap -F pcap in.pcapng out.pcap`");
      }
      interface.ticks_per_s = 1;
      for (unsigned i = 0; i < exponent; ++i) interface.ticks_per_s *= 10;
    }
    at += 4 + static_cast<std::size_t>(padded(size));
  }
  interfaces_.push_back(interface);
  return {};
}

// False at the end of the file.
Result<bool> PcapReader::next_block(Block& block) {
  std::array<char, 8> head{};
  file_.read(head.data(), head.size());
  if (file_.gcount() == 0) return false;
  if (file_.gcount() != static_cast<std::streamsize>(head.size())) {
    return error(ErrorCode::kTruncatedScan, "the file ends within the header of a block");
  }
  block.type = number(head.data());
  const std::uint32_t length = number(head.data() + 4);
  if (length < kBlockFrame || length % 4 != 0 || length > 2 * kMostFrame) {
    return error(ErrorCode::kMalformedHeader, concat("found a block of ", length, " bytes"));
  }
  block.body.resize(length - 8);
  file_.read(block.body.data(), static_cast<std::streamsize>(block.body.size()));
  if (file_.gcount() != static_cast<std::streamsize>(block.body.size())) {
    return error(ErrorCode::kTruncatedScan, "the file ends within a block");
  }
  if (number(block.body.data() + block.body.size() - 4) != length) {
    return error(ErrorCode::kMalformedHeader, "a block's two lengths differ");
  }
  block.body.resize(block.body.size() - 4);
  offset_ += length;
  return true;
}

Result<bool> PcapReader::next(PcapPacket& packet) {
  return is_pcapng_ ? next_of_section(packet) : next_classic(packet);
}

Result<bool> PcapReader::next_of_section(PcapPacket& packet) {
  Block block;
  while (true) {
    packet.offset = offset_;
    SIGHTLINE_ASSIGN(const bool more, next_block(block));
    if (!more) return false;
    if (block.type == kSectionHeader || block.type == kInterface || block.type == kSimplePacket) {
      return error(ErrorCode::kUnsupportedFormat,
                   "found a second section, a late interface or a packet without a time; convert "
                   "it with `editcap -F pcap in.pcapng out.pcap`");
    }
    if (block.type == kEnhancedPacket) break;
  }
  constexpr std::size_t kPacketHead = 20;
  const std::vector<char>& body = block.body;
  if (body.size() < kPacketHead) {
    return error(ErrorCode::kMalformedHeader, "a packet is shorter than its header");
  }
  const std::uint32_t interface_id = number(body.data());
  const std::uint32_t size = number(body.data() + 12);
  if (interface_id >= interfaces_.size() || size > body.size() - kPacketHead) {
    return error(ErrorCode::kMalformedHeader,
                 "a packet without an interface, or longer than its block");
  }
  const Interface& interface = interfaces_[interface_id];
  const std::uint64_t ticks =
      std::uint64_t{number(body.data() + 4)} << 32U | number(body.data() + 8);
  const std::uint64_t seconds = ticks / interface.ticks_per_s;
  constexpr std::uint64_t kMost_s = 4'000'000'000;  // as a classic pcap can tell
  if (seconds > kMost_s) return error(ErrorCode::kMalformedHeader, "a packet after the year 2096");
  packet.time_ns = static_cast<std::int64_t>(
      seconds * kSecond_ns + ticks % interface.ticks_per_s * (kSecond_ns / interface.ticks_per_s));
  const std::span<const std::byte> frame =
      std::as_bytes(std::span(body.data() + kPacketHead, size));
  take_frame(frame, interface.link_type, packet);
  return true;
}

Result<bool> PcapReader::next_classic(PcapPacket& packet) {
  std::array<char, kRecordHeaderSize> header{};
  file_.read(header.data(), header.size());
  if (file_.gcount() == 0) return false;
  if (file_.gcount() != static_cast<std::streamsize>(kRecordHeaderSize)) {
    return error(ErrorCode::kTruncatedScan, "the file ends within the header of a packet");
  }
  const std::uint32_t size = number(header.data() + 8);
  if (size > kMostFrame) {
    return error(ErrorCode::kMalformedHeader,
                 concat("found a packet of ", size, " bytes, expected at most ", kMostFrame));
  }
  // No packet, but a hole in the file, which may be of any length.
  if (size == 0 && number(header.data() + 12) == 0) {
    return error(ErrorCode::kMalformedHeader, "found a packet of 0 bytes");
  }
  std::vector<std::byte> frame(size);
  file_.read(reinterpret_cast<char*>(frame.data()), size);
  if (file_.gcount() != static_cast<std::streamsize>(size)) {
    return error(ErrorCode::kTruncatedScan, "the file ends within a packet");
  }
  packet.offset = offset_;
  packet.time_ns = number(header.data()) * kSecond_ns + number(header.data() + 4) * tick_ns_;
  take_frame(frame, link_type_, packet);
  offset_ += kRecordHeaderSize + size;
  return true;
}

void PcapReader::take_frame(std::span<const std::byte> frame, std::uint32_t link_type,
                            PcapPacket& packet) {
  IpDatagrams::Datagram datagram = datagrams_.add(frame, *link_size(link_type), packet.offset);
  packet.datagram = std::move(datagram.payload);
  if (!packet.datagram.empty()) packet.offset = datagram.offset;
}

void PcapReader::seek(std::uint64_t offset) {
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(offset));
  offset_ = offset;
  datagrams_.clear();
}

IpDatagrams::Open& IpDatagrams::open_of(std::span<const std::byte> ip, std::uint64_t offset) {
  std::vector<std::byte> key = copy_of(ip.subspan(12, 8));
  key.push_back(ip[4]);
  key.push_back(ip[5]);
  const auto found = std::ranges::find(open_, key, &Open::key);
  if (found != open_.end()) return *found;
  std::erase_if(open_, [&](const Open& open) { return open.serial + kLongestWait < next_serial_; });
  if (open_.size() == kMostOpen) open_.erase(open_.begin());
  open_.push_back({std::move(key), {}, {}, false, offset, next_serial_++});
  return open_.back();
}

IpDatagrams::Datagram IpDatagrams::add_fragment(std::span<const std::byte> ip,
                                                std::size_t ip_header, std::uint64_t offset) {
  const std::size_t flags = big16(ip, 6);
  const bool is_last = (flags & 0x2000U) == 0;
  const std::size_t begin = kUnit * (flags & 0x1fffU);
  const std::size_t total = big16(ip, 2);
  if (total <= ip_header || total > ip.size()) return {};
  const std::span<const std::byte> part = ip.subspan(ip_header, total - ip_header);
  const std::size_t end = begin + part.size();
  if (end > kMostBytes || (!is_last && part.size() % kUnit != 0)) return {};
  Open& open = open_of(ip, offset);
  // What does not fit what came before is of another datagram, or damaged.
  if (open.has_end ? end > open.bytes.size() : (is_last && end < open.bytes.size())) return {};
  if (end > open.bytes.size()) {
    open.bytes.resize(end);
    open.is_there.resize((end + kUnit - 1) / kUnit);
  }
  open.has_end = open.has_end || is_last;
  std::ranges::copy(part, open.bytes.begin() + static_cast<std::ptrdiff_t>(begin));
  for (std::size_t unit = begin / kUnit; unit * kUnit < end; ++unit) open.is_there[unit] = true;
  if (!open.has_end || !std::ranges::all_of(open.is_there, [](bool is) { return is; })) return {};
  Datagram made{copy_of(payload_of(open.bytes)), open.offset};
  open_.erase(open_.begin() + (&open - open_.data()));
  return made;
}

IpDatagrams::Datagram IpDatagrams::add(std::span<const std::byte> frame, std::size_t link,
                                       std::uint64_t offset) {
  constexpr std::size_t kVlanTag = 4;
  constexpr std::size_t kVlan = 0x8100;
  constexpr std::size_t kEthernet = 14;
  if (link == kEthernet && frame.size() > kEthernet && big16(frame, 12) == kVlan) link += kVlanTag;
  if (frame.size() < link + kIpHeader) return {};
  const std::span<const std::byte> ip = frame.subspan(link);
  const auto first = std::to_integer<unsigned>(ip[0]);
  const std::size_t ip_header = 4U * (first & 15U);
  const bool is_udp = first >> 4U == 4U && ip[9] == std::byte{17} && ip_header >= kIpHeader;
  if (!is_udp || ip.size() < ip_header) return {};
  const bool is_fragment = (big16(ip, 6) & 0x3fffU) != 0;
  if (is_fragment) return add_fragment(ip, ip_header, offset);
  return {copy_of(payload_of(ip.subspan(ip_header))), offset};
}

}  // namespace sightline
