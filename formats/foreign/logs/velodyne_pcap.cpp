#include "formats/foreign/logs/velodyne_pcap.h"

#include <utility>

#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/velodyne_packet.h"
#include "formats/foreign/logs/velodyne_revolutions.h"

namespace sightline {
namespace {

constexpr std::size_t kStoredSize = sizeof(std::int64_t) + kVelodynePacketSize;

class VelodynePcap : public ScanContainer {
 public:
  VelodynePcap(std::filesystem::path path, RevolutionIndex index)
      : path_(std::move(path)), revolutions_(std::move(index.revolutions)) {
    scans_ = std::move(index.scans);
    warnings_ = std::move(index.warnings);
  }

  Result<std::vector<std::byte>> read(std::size_t index) const override;
  Result<PointCloudFile> parse(std::span<const std::byte> bytes, std::size_t index) const override;

 private:
  std::filesystem::path path_;
  std::vector<Revolution> revolutions_;
};

Result<std::vector<std::byte>> VelodynePcap::read(std::size_t index) const {
  const Revolution& revolution = revolutions_.at(index);
  SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path_));
  reader.seek(revolution.offset);
  HourClock clock;
  std::optional<std::int64_t> before_ns;
  ByteWriter bytes;
  PcapPacket packet;
  while (bytes.bytes().size() < revolution.packet_count * kStoredSize) {
    SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
    if (!more) {
      return Error{ErrorCode::kCannotRead, "the file has become shorter since it was opened",
                   path_.string(), "byte " + std::to_string(revolution.offset)};
    }
    if (packet.datagram.size() != kVelodynePacketSize) continue;
    const std::int64_t time_ns =
        clock.absolute_ns(VelodynePacket(packet.datagram).hour_us(), revolution.first_ns);
    if (before_ns == time_ns) continue;  // captured twice
    before_ns = time_ns;
    store_packet(time_ns, packet.datagram, bytes);
  }
  return bytes.take();
}

Result<PointCloudFile> VelodynePcap::parse(std::span<const std::byte> bytes,
                                           std::size_t index) const {
  const Revolution& revolution = revolutions_.at(index);
  const std::int64_t stamp_ns = scans_.at(index).stamp_ns;
  SIGHTLINE_CHECK(bytes.size() == revolution.packet_count * kStoredSize);
  PointCloudFile cloud;
  for (std::size_t i = 0; i < revolution.packet_count; ++i) {
    const std::span<const std::byte> stored = bytes.subspan(i * kStoredSize, kStoredSize);
    const auto time_ns = ByteReader(stored).get<std::int64_t>();
    const VelodynePacket packet(stored.subspan(sizeof time_ns));
    const bool is_last = i + 1 == revolution.packet_count;
    const std::size_t end = is_last ? revolution.end_block : kVelodyneBlocks;
    for (std::size_t block = i == 0 ? revolution.first_block : 0; block < end; ++block) {
      packet.append_block(block, time_ns - stamp_ns, cloud);
    }
  }
  return cloud;
}

}  // namespace

Result<std::shared_ptr<const ScanContainer>> open_velodyne_pcap(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(RevolutionIndex index, find_revolutions(path));
  return std::shared_ptr<const ScanContainer>(
      std::make_shared<VelodynePcap>(path, std::move(index)));
}

}  // namespace sightline
