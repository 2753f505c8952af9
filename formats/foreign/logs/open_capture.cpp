#include "formats/foreign/logs/open_capture.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/logs/hesai_lidar.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/rotating_pcap.h"
#include "formats/foreign/logs/velodyne_packet.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/ouster_metadata.h"
#include "formats/foreign/text/sensor_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

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
    return unsigned{read_at<std::uint16_t>(datagram, header + i * column + 8)};
  };
  return number(1) == number(0) + 1 && number(2) == number(0) + 2;
}

std::optional<Maker> maker_of(std::span<const std::byte> datagram) {
  if (is_velodyne(datagram)) return Maker::kVelodyne;
  if (is_hesai_packet(datagram)) return Maker::kHesai;
  if (is_ouster(datagram)) return Maker::kOuster;
  return std::nullopt;
}

Result<Found> find_maker(const fs::path& path) {
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

// The only file of that ending beside a capture that is one; empty: there is none, or several.
template <class Test>
fs::path only_beside(const fs::path& capture, const char* ending, const Test& is_one) {
  std::error_code ignored;
  fs::path only;
  const fs::path folder = capture.has_parent_path() ? capture.parent_path() : fs::path(".");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (lower_extension(entry.path()) != ending || !entry.is_regular_file(ignored)) continue;
    if (!is_one(entry.path())) continue;
    if (!only.empty()) return {};
    only = entry.path();
  }
  return only;
}

// The metadata of a capture: `named` where it is a .json, else the file beside the capture with its
// name and that ending, else the only one there. Empty: none.
fs::path ouster_metadata_of(const fs::path& capture, const fs::path& named) {
  if (lower_extension(named) == ".json") return named;
  std::error_code ignored;
  // `ouster-cli` numbers the sensors of a capture.
  for (const char* ending : {".json", "_0.json"}) {
    const fs::path beside = capture.parent_path() / (capture.stem().string() + ending);
    if (fs::is_regular_file(beside, ignored)) return beside;
  }
  return only_beside(capture, ".json", [](const fs::path& file) {
    const Result<std::string> text = read_short_text(file, kLargestOusterMetadata);
    return text && parse_ouster_metadata(*text, file);
  });
}

// The angle correction file of a capture: `named` where it is a .csv, else the file beside the
// capture with its name and that ending, else the only such file there. Empty: none.
fs::path hesai_correction_of(const fs::path& capture, const fs::path& named) {
  if (lower_extension(named) == ".csv") return named;
  const auto is_correction = [](const fs::path& file) {
    const Result<std::string> text = read_short_text(file, kLargestHesaiCorrection);
    if (!text) return false;
    const Result<std::vector<BeamRow>> rows = parse_beam_table(*text, file.string());
    return rows && !rows->empty() && rows->front().azimuth_deg;
  };
  std::error_code ignored;
  const fs::path beside = fs::path(capture).replace_extension(".csv");
  if (fs::is_regular_file(beside, ignored) && is_correction(beside)) return beside;
  return only_beside(capture, ".csv", is_correction);
}

Result<std::shared_ptr<const ScanContainer>> open_ouster(const fs::path& path,
                                                         const fs::path& sensor) {
  const fs::path metadata = ouster_metadata_of(path, sensor);
  if (!metadata.empty()) return open_ouster_pcap(path, metadata);
  return Error{ErrorCode::kMissingField,
               concat("packets of an Ouster sensor need its metadata. Save it with `ouster-cli` or "
                      "from the sensor's web page, and put it beside the capture as ",
                      path.stem().string(), ".json, or name it as `sensor`"),
               path.string()};
}

Result<std::shared_ptr<const ScanContainer>> open_hesai(const fs::path& path,
                                                        const fs::path& sensor,
                                                        std::span<const std::byte> first_packet) {
  const fs::path correction = hesai_correction_of(path, sensor);
  Result<std::unique_ptr<const RotatingLidar>> lidar = hesai_lidar(first_packet, correction);
  if (!lidar) return in_file(lidar.error(), path.string());
  return open_rotating_pcap(path, std::move(*lidar));
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
      concat(
          "found no packets of a supported LiDAR among the first ", found.datagrams,
          " datagrams, expected Velodyne (VLP-16, HDL-32E), Hesai (Pandar64, Pandar128, "
          "PandarXT-32, PandarXT-16) or Ouster; replay the capture to the sensor's ROS driver and "
          "record its points in a bag, or export the scans as PCD with its own tools"),
      path.string()};
}

}  // namespace sightline
