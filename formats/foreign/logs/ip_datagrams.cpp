#include "formats/foreign/logs/ip_datagrams.h"

#include <algorithm>
#include <utility>

namespace sightline {
namespace {

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
