#include "formats/foreign/logs/velodyne_lidar.h"

#include "formats/foreign/logs/velodyne_packet.h"

namespace sightline {

bool VelodyneLidar::is_data(std::span<const std::byte> datagram) const {
  return datagram.size() == kVelodynePacketSize;
}

std::size_t VelodyneLidar::packet_size() const { return kVelodynePacketSize; }

Result<void> VelodyneLidar::check(std::span<const std::byte> bytes) const {
  const VelodynePacket packet(bytes);
  if (!packet.is_valid()) {
    return Error{ErrorCode::kMalformedHeader,
                 "found 1206 bytes of UDP that are no Velodyne data packet"};
  }
  if (packet.model()) return {};
  return Error{ErrorCode::kUnsupportedFormat,
               "found product id " + std::to_string(packet.product_id()) +
                   ", expected packets of one HDL-32E (33) or VLP-16 (34); export the scans as "
                   "PCD with the sensor's own tools"};
}

int VelodyneLidar::model(std::span<const std::byte> bytes) const {
  return VelodynePacket(bytes).product_id();
}

std::size_t VelodyneLidar::block_count() const { return kVelodyneBlocks; }

unsigned VelodyneLidar::azimuth_cdeg(std::span<const std::byte> bytes, std::size_t block) const {
  return VelodynePacket(bytes).azimuth_cdeg(block);
}

std::int64_t VelodyneLidar::time_ns(std::span<const std::byte> bytes) const {
  return std::int64_t{VelodynePacket(bytes).hour_us()} * 1000;
}

std::int64_t VelodyneLidar::block_offset_ns(std::span<const std::byte> bytes,
                                            std::size_t block) const {
  return VelodynePacket(bytes).block_offset_ns(block);
}

void VelodyneLidar::append_block(std::span<const std::byte> bytes, std::size_t block,
                                 std::int64_t base_ns, PointCloudFile& cloud) const {
  VelodynePacket(bytes).append_block(block, base_ns, cloud);
}

}  // namespace sightline
