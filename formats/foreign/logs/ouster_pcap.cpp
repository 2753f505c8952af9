#include "formats/foreign/logs/ouster_pcap.h"

#include <utility>

#include "formats/base/check.h"
#include "formats/base/files/atomic_file.h"
#include "formats/foreign/logs/ouster_frames.h"
#include "formats/foreign/logs/pcap_reader.h"

namespace sightline {
namespace {

class OusterPcap : public ScanContainer {
 public:
  OusterPcap(std::filesystem::path path, const std::filesystem::path& metadata,
             OusterPackets packets, OusterFrameIndex index)
      : path_(std::move(path)), packets_(std::move(packets)), frames_(std::move(index.frames)) {
    scans_ = std::move(index.scans);
    warnings_ = std::move(index.warnings);
    sensor_file_ = metadata;
  }

  Result<std::vector<std::byte>> read(std::size_t index) const override;
  Result<PointCloudFile> parse(std::span<const std::byte> bytes, std::size_t index) const override;

 private:
  std::filesystem::path path_;
  OusterPackets packets_;
  std::vector<OusterFrame> frames_;
};

Result<std::vector<std::byte>> OusterPcap::read(std::size_t index) const {
  const OusterFrame& frame = frames_.at(index);
  SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path_));
  reader.seek(frame.offset);
  OusterFramePackets collected(packets_);
  PcapPacket packet;
  while (collected.count() < frame.packet_count) {
    SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
    if (!more) {
      return Error{ErrorCode::kCannotRead, "the file has become shorter since it was opened",
                   path_.string(), "byte " + std::to_string(frame.offset)};
    }
    if (!packets_.is_data(packet.datagram)) continue;
    if (packets_.frame_id(packet.datagram) == frame.frame_id) collected.add(packet.datagram);
  }
  return collected.bytes();
}

Result<PointCloudFile> OusterPcap::parse(std::span<const std::byte> bytes,
                                         std::size_t index) const {
  const OusterFrame& frame = frames_.at(index);
  const std::size_t size = packets_.size();
  SIGHTLINE_CHECK(bytes.size() >= frame.packet_count * size);
  const std::span<const std::byte> stored = bytes.last(frame.packet_count * size);
  PointCloudFile cloud;
  for (std::size_t i = 0; i < frame.packet_count; ++i) {
    const std::span<const std::byte> packet = stored.subspan(i * size, size);
    for (std::size_t column = 0; column < packets_.column_count(); ++column) {
      if (!packets_.is_valid(packet, column)) continue;
      // Within a second of the stamp: find_ouster_frames made sure.
      const auto offset_ns =
          static_cast<std::int32_t>(packets_.time_ns(packet, column) - frame.stamp_ns);
      packets_.append_column(packet, column, offset_ns, cloud);
    }
  }
  return cloud;
}

Error of_file(Error error, const std::filesystem::path& file) {
  if (error.file.empty()) error.file = file.string();
  return error;
}

}  // namespace

Result<std::shared_ptr<const ScanContainer>> open_ouster_pcap(
    const std::filesystem::path& path, const std::filesystem::path& metadata) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(metadata, kLargestOusterMetadata));
  SIGHTLINE_ASSIGN(const OusterMetadata sensor, parse_ouster_metadata(text, metadata));
  Result<OusterPackets> packets = OusterPackets::of(sensor);
  if (!packets) return of_file(packets.error(), metadata);
  SIGHTLINE_ASSIGN(OusterFrameIndex index, find_ouster_frames(path, *packets));
  return std::shared_ptr<const ScanContainer>(
      std::make_shared<OusterPcap>(path, metadata, std::move(*packets), std::move(index)));
}

}  // namespace sightline
