#include "formats/foreign/logs/open_capture.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "formats/foreign/logs/hesai_lidar.h"
#include "formats/foreign/logs/ouster_pcap.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/rotating_pcap.h"
#include "formats/foreign/logs/velodyne_packet.h"
#include "formats/foreign/text/ouster_metadata.h"

namespace sightline {
namespace {

enum class Maker { kVelodyne, kHesai, kOuster };

struct Found {
  std::optional<Maker> maker;
  std::vector<std::byte> first_packet;  // of that maker
  std::uint64_t datagrams = 0;          // that were looked at
};

bool is_velodyne(std::span<const std::byte> datagram) {
  return datagram.size() == kVelodynePacketSize && datagram[0] == std::byte{0xff} &&
         datagram[1] == std::byte{0xee};
}

// Sixteen columns of successive numbers; legacy packets are known by the sizes that 16, 32, 64 and
// 128 beams give, the others begin with the type of their packet, 1.
bool is_ouster(std::span<const std::byte> datagram) {
  constexpr std::array<std::size_t, 4> kLegacySizes = {3392, 6464, 12608, 24896};
  constexpr std::size_t kColumns = 16;
  constexpr std::size_t kHeader = 32;
  constexpr std::size_t kShortest = 1000;
  if (datagram.size() < kShortest || datagram.size() % kColumns != 0) return false;
  const bool is_legacy = std::ranges::find(kLegacySizes, datagram.size()) != kLegacySizes.end();
  if (!is_legacy && (datagram[0] != std::byte{1} || datagram[1] != std::byte{0})) return false;
  const std::size_t header = is_legacy ? 0 : kHeader;
  const std::size_t column = (datagram.size() - 2 * header) / kColumns;
  const auto number = [&](std::size_t i) {
    const std::size_t at = header + i * column + 8;
    return std::to_integer<unsigned>(datagram[at]) | std::to_integer<unsigned>(datagram[at + 1])
                                                         << 8U;
  };
  return number(1) == number(0) + 1 && number(2) == number(0) + 2;
}

std::optional<Maker> maker_of(std::span<const std::byte> datagram) {
  if (is_velodyne(datagram)) return Maker::kVelodyne;
  if (is_hesai_packet(datagram)) return Maker::kHesai;
  if (is_ouster(datagram)) return Maker::kOuster;
  return std::nullopt;
}

Result<Found> find_maker(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostPackets = 20'000;  // some seconds of a LiDAR among other traffic
  SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path));
  Found found;
  PcapPacket packet;
  for (std::uint64_t i = 0; i < kMostPackets; ++i) {
    SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
    if (!more) break;
    if (packet.datagram.empty()) continue;
    ++found.datagrams;
    found.maker = maker_of(packet.datagram);
    if (!found.maker) continue;
    found.first_packet = std::move(packet.datagram);
    break;
  }
  return found;
}

Result<std::shared_ptr<const ScanContainer>> open_ouster(const std::filesystem::path& path,
                                                         const std::filesystem::path& sensor) {
  const std::filesystem::path metadata = ouster_metadata_of(path, sensor);
  if (!metadata.empty()) return open_ouster_pcap(path, metadata);
  return Error{ErrorCode::kMissingField,
               "packets of an Ouster sensor need its metadata, which `ouster-cli` and the sensor's "
               "web page save: put it beside the capture as " +
                   path.stem().string() + ".json, or name it as `sensor`",
               path.string()};
}

Result<std::shared_ptr<const ScanContainer>> open_hesai(const std::filesystem::path& path,
                                                        const std::filesystem::path& sensor,
                                                        std::span<const std::byte> first_packet) {
  const std::filesystem::path correction = hesai_correction_of(path, sensor);
  Result<std::unique_ptr<const RotatingLidar>> lidar = hesai_lidar(first_packet, correction);
  if (lidar) return open_rotating_pcap(path, std::move(*lidar));
  Error error = lidar.error();
  if (error.file.empty()) error.file = path.string();
  return error;
}

}  // namespace

Result<std::shared_ptr<const ScanContainer>> open_capture(const std::filesystem::path& path,
                                                          const std::filesystem::path& sensor) {
  SIGHTLINE_ASSIGN(const Found found, find_maker(path));
  if (found.maker == Maker::kOuster) return open_ouster(path, sensor);
  if (found.maker == Maker::kHesai) return open_hesai(path, sensor, found.first_packet);
  if (found.maker == Maker::kVelodyne || found.datagrams == 0) return open_velodyne_pcap(path);
  return Error{
      ErrorCode::kUnsupportedFormat,
      "found no packets of a LiDAR that is read among the first " +
          std::to_string(found.datagrams) +
          " datagrams, expected Velodyne (VLP-16, HDL-32E), Hesai (Pandar64, Pandar128, "
          "PandarXT-32, PandarXT-16) or Ouster; replay the capture to the sensor's ROS driver and "
          "record its points in a bag, or export the scans as PCD with its own tools",
      path.string()};
}

}  // namespace sightline
