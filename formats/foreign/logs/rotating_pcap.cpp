#include "formats/foreign/logs/rotating_pcap.h"

#include <utility>

#include "formats/base/check.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/revolutions.h"
#include "formats/foreign/logs/velodyne_lidar.h"

namespace sightline {
namespace {

class RotatingPcap : public ScanContainer {
 public:
  RotatingPcap(std::filesystem::path path, std::unique_ptr<const RotatingLidar> lidar,
               RevolutionIndex index)
      : path_(std::move(path)),
        lidar_(std::move(lidar)),
        revolutions_(std::move(index.revolutions)) {
    scans_ = std::move(index.scans);
    warnings_ = std::move(index.warnings);
  }

  Result<std::vector<std::byte>> read(std::size_t index) const override;
  Result<PointCloudFile> parse(std::span<const std::byte> bytes, std::size_t index) const override;

 private:
  std::filesystem::path path_;
  std::unique_ptr<const RotatingLidar> lidar_;
  std::vector<Revolution> revolutions_;
};

Result<std::vector<std::byte>> RotatingPcap::read(std::size_t index) const {
  const Revolution& revolution = revolutions_.at(index);
  SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path_));
  reader.seek(revolution.offset);
  PacketClock clock(lidar_->has_date());
  std::optional<std::int64_t> before_ns;
  ByteWriter bytes = begin_scan(*lidar_);
  PcapPacket packet;
  for (std::size_t count = 0; count < revolution.packet_count;) {
    SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
    if (!more) {
      return Error{ErrorCode::kCannotRead, "the file has become shorter since it was opened",
                   path_.string(), "byte " + std::to_string(revolution.offset)};
    }
    if (!lidar_->is_data(packet.datagram)) continue;
    const std::int64_t time_ns =
        clock.absolute_ns(lidar_->time_ns(packet.datagram), revolution.first_ns);
    if (before_ns == time_ns) continue;  // captured twice
    before_ns = time_ns;
    store_packet(*lidar_, time_ns, packet.datagram, bytes);
    ++count;
  }
  return bytes.take();
}

Result<PointCloudFile> RotatingPcap::parse(std::span<const std::byte> bytes,
                                           std::size_t index) const {
  const Revolution& revolution = revolutions_.at(index);
  const std::int64_t stamp_ns = scans_.at(index).stamp_ns;
  const std::size_t size = stored_size(*lidar_);
  SIGHTLINE_CHECK(bytes.size() >= revolution.packet_count * size);
  const std::span<const std::byte> packets = bytes.last(revolution.packet_count * size);
  PointCloudFile cloud;
  for (std::size_t i = 0; i < revolution.packet_count; ++i) {
    const std::span<const std::byte> stored = packets.subspan(i * size, size);
    const auto time_ns = ByteReader(stored).get<std::int64_t>();
    const std::span<const std::byte> packet = stored.subspan(sizeof time_ns);
    const bool is_last = i + 1 == revolution.packet_count;
    const std::size_t end = is_last ? revolution.end_block : lidar_->block_count();
    for (std::size_t block = i == 0 ? revolution.first_block : 0; block < end; ++block) {
      lidar_->append_block(packet, block, time_ns - stamp_ns, cloud);
    }
  }
  return cloud;
}

}  // namespace

Result<std::shared_ptr<const ScanContainer>> open_rotating_pcap(
    const std::filesystem::path& path, std::unique_ptr<const RotatingLidar> lidar) {
  SIGHTLINE_ASSIGN(RevolutionIndex index, find_revolutions(path, *lidar));
  return std::shared_ptr<const ScanContainer>(
      std::make_shared<RotatingPcap>(path, std::move(lidar), std::move(index)));
}

Result<std::shared_ptr<const ScanContainer>> open_velodyne_pcap(const std::filesystem::path& path) {
  return open_rotating_pcap(path, std::make_unique<VelodyneLidar>());
}

}  // namespace sightline
