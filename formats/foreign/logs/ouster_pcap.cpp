#include <algorithm>
#include <optional>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/units.h"
#include "formats/foreign/logs/open_capture.h"
#include "formats/foreign/logs/ouster_packet.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/rotating_pcap.h"

namespace sightline {
namespace {

// Where one frame of an Ouster sensor lies in a pcap.
struct OusterFrame {
  std::uint64_t offset = 0;  // of the record of its first packet, bytes
  std::uint16_t frame_id = 0;
  std::size_t packet_count = 0;  // none of them twice
  std::int64_t stamp_ns = 0;     // of its earliest column, of the sensor's clock as it is
};

struct OusterFrameIndex {
  std::vector<OusterFrame> frames;
  std::vector<ContainedScan> scans;  // one each; content: of the calibration and the packets
  std::vector<std::string> warnings;
};

// The packets of one frame, none of them twice.
class OusterFramePackets {
 public:
  explicit OusterFramePackets(const OusterPackets& packets)
      : packets_(&packets),
        is_there_(packets.columns_per_frame() / packets.column_count() + 1),
        bytes_(packets.calibration()) {}

  // False: one with the same columns is there already, or its columns are no frame's.
  bool add(std::span<const std::byte> packet) {
    const std::size_t slot = packets_->measurement_id(packet, 0) / packets_->column_count();
    if (slot >= is_there_.size() || is_there_[slot]) return false;
    is_there_[slot] = true;
    ++count_;
    bytes_.insert(bytes_.end(), packet.begin(), packet.end());
    return true;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  // The calibration, then the packets.
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  const OusterPackets* packets_;
  std::vector<bool> is_there_;
  std::size_t count_ = 0;
  std::vector<std::byte> bytes_;
};

constexpr std::int64_t kLongestFrame_ns = kSecond_ns;
constexpr std::size_t kMostMissing = 10;  // of a frame's packets, one in so many

// The first and the last time of a frame's columns that were measured.
struct Span {
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
};

std::optional<Span> span_of(const OusterPackets& packets, std::span<const std::byte> packet,
                            std::optional<Span> span) {
  for (std::size_t column = 0; column < packets.column_count(); ++column) {
    if (!packets.is_valid(packet, column)) continue;
    const std::int64_t time_ns = packets.time_ns(packet, column);
    if (!span) span = Span{time_ns, time_ns};
    span->first_ns = std::min(span->first_ns, time_ns);
    span->last_ns = std::max(span->last_ns, time_ns);
  }
  return span;
}

class FrameFinder {
 public:
  FrameFinder(std::filesystem::path path, const OusterPackets& packets)
      : path_(std::move(path)), packets_(packets), clock_(true) {}

  Result<void> add(const PcapPacket& packet);
  Result<OusterFrameIndex> finish();

 private:
  Result<void> check(const PcapPacket& packet);
  Result<void> close();
  void warn();
  [[nodiscard]] Error error(ErrorCode code, std::string message, std::uint64_t offset) const {
    return {code, std::move(message), path_.string(), "byte " + std::to_string(offset)};
  }

  std::filesystem::path path_;
  const OusterPackets& packets_;
  OusterFrameIndex index_;
  PacketClock clock_;
  std::optional<OusterFrame> open_;  // the one that goes on
  std::optional<OusterFramePackets> collected_;
  std::optional<Span> span_;
  std::optional<std::uint16_t> closed_id_;
  std::int64_t captured_ns_ = 0;  // the packet that gave the first time
  std::uint64_t data_packets_ = 0;
  std::uint64_t other_packets_ = 0;
  std::uint64_t left_out_ = 0;  // frames
  std::uint64_t missing_ = 0;   // packets, of frames that are kept
};

Result<void> FrameFinder::check(const PcapPacket& packet) {
  for (std::size_t column = 0; column < packets_.column_count(); ++column) {
    const std::size_t id = packets_.measurement_id(packet.datagram, column);
    if (id < packets_.columns_per_frame()) continue;
    return error(ErrorCode::kMismatchedInputs,
                 "found column " + std::to_string(id) + ", but the metadata has " +
                     std::to_string(packets_.columns_per_frame()) +
                     " a frame: it is of another sensor or another mode",
                 packet.offset);
  }
  return {};
}

Result<void> FrameFinder::close() {
  if (!open_) return {};
  const std::size_t whole = packets_.packets_per_frame();
  const bool is_kept = collected_->count() + whole / kMostMissing >= whole && span_ &&
                       span_->last_ns - span_->first_ns <= kLongestFrame_ns;
  if (is_kept) {
    open_->packet_count = collected_->count();
    open_->stamp_ns = span_->first_ns;
    const std::int64_t stamp_ns = clock_.absolute_ns(span_->first_ns, captured_ns_);
    if (!index_.scans.empty() && stamp_ns <= index_.scans.back().stamp_ns) {
      return error(ErrorCode::kTimeRunsBackwards,
                   "the sensor's clock goes back by " +
                       std::to_string((index_.scans.back().stamp_ns - stamp_ns) / 1000) + " us",
                   open_->offset);
    }
    if (collected_->count() < whole) missing_ += whole - collected_->count();
    index_.scans.push_back({stamp_ns, sha256(collected_->bytes())});
    index_.frames.push_back(*open_);
  } else {
    ++left_out_;
  }
  closed_id_ = open_->frame_id;
  open_.reset();
  return {};
}

Result<void> FrameFinder::add(const PcapPacket& packet) {
  if (!packets_.is_data(packet.datagram)) {
    ++other_packets_;
    return {};
  }
  SIGHTLINE_TRY(check(packet));
  const std::uint16_t frame_id = packets_.frame_id(packet.datagram);
  if (!open_ || frame_id != open_->frame_id) {
    if (frame_id == closed_id_) {  // late
      ++other_packets_;
      return {};
    }
    SIGHTLINE_TRY(close());
    open_ = OusterFrame{packet.offset, frame_id, 0, 0};
    collected_.emplace(packets_);
    span_.reset();
  }
  if (!collected_->add(packet.datagram)) {
    ++other_packets_;
    return {};
  }
  ++data_packets_;
  open_->offset = std::min(open_->offset, packet.offset);
  const bool is_first = !span_ && index_.scans.empty();
  span_ = span_of(packets_, packet.datagram, span_);
  if (is_first) captured_ns_ = packet.time_ns;
  return {};
}

void FrameFinder::warn() {
  const std::string name = path_.filename().string();
  index_.warnings.push_back(
      name + ": " + std::to_string(index_.frames.size()) + " frames in " +
      std::to_string(data_packets_) + " data packets; " + std::to_string(left_out_) +
      " frames of which over a tenth is missing were left out, and " +
      std::to_string(other_packets_) + " packets of other kinds, late or twice");
  if (missing_ > 0) {
    index_.warnings.push_back(name + ": " + std::to_string(missing_) +
                              " packets of the frames are missing");
  }
  if (clock_.is_shifted()) {
    index_.warnings.push_back(name +
                              ": the sensor's clock was not set; its times count from when the "
                              "first packet was captured");
  }
}

Result<OusterFrameIndex> FrameFinder::finish() {
  SIGHTLINE_TRY(close());
  if (index_.frames.empty()) {
    return error(ErrorCode::kDriveTooShort,
                 "no whole frame of an Ouster sensor among " + std::to_string(data_packets_) +
                     " data packets of " + std::to_string(packets_.size()) + " bytes and " +
                     std::to_string(other_packets_) +
                     " others; of several sensors in one capture none is read: keep one, for "
                     "example with `tshark -r in.pcap -Y \"ip.src == ADDRESS\" -w out.pcap`",
                 0);
  }
  warn();
  return std::move(index_);
}

// Walks through the file once, holding one frame. A frame of which more than a tenth of the packets
// is missing, whose columns span over a second or which none of them measured is left out and
// counted. Stamps are the sensor's; where its clock counts from its start (before 2005), from when
// the first packet was captured. Errors: those of PcapReader, mismatched-inputs (columns that no
// frame has), time-runs-backwards, drive-too-short (no frame).
Result<OusterFrameIndex> find_ouster_frames(const std::filesystem::path& path,
                                            const OusterPackets& packets) {
  FrameFinder finder(path, packets);
  SIGHTLINE_TRY(visit_packets(path, [&](const PcapPacket& packet) { return finder.add(packet); }));
  return finder.finish();
}

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

}  // namespace

Result<std::shared_ptr<const ScanContainer>> open_ouster_pcap(
    const std::filesystem::path& path, const std::filesystem::path& metadata) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(metadata, kLargestOusterMetadata));
  SIGHTLINE_ASSIGN(const OusterMetadata sensor, parse_ouster_metadata(text, metadata));
  Result<OusterPackets> packets = OusterPackets::of(sensor);
  if (!packets) return in_file(packets.error(), metadata.string());
  SIGHTLINE_ASSIGN(OusterFrameIndex index, find_ouster_frames(path, *packets));
  return std::shared_ptr<const ScanContainer>(
      std::make_shared<OusterPcap>(path, metadata, std::move(*packets), std::move(index)));
}

}  // namespace sightline
