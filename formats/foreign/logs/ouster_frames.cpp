#include "formats/foreign/logs/ouster_frames.h"

#include <algorithm>
#include <utility>

#include "formats/base/units.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/revolutions.h"

namespace sightline {
namespace {

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

}  // namespace

OusterFramePackets::OusterFramePackets(const OusterPackets& packets)
    : packets_(&packets),
      is_there_(packets.columns_per_frame() / packets.column_count() + 1),
      bytes_(packets.calibration()) {}

bool OusterFramePackets::add(std::span<const std::byte> packet) {
  const std::size_t slot = packets_->measurement_id(packet, 0) / packets_->column_count();
  if (slot >= is_there_.size() || is_there_[slot]) return false;
  is_there_[slot] = true;
  ++count_;
  bytes_.insert(bytes_.end(), packet.begin(), packet.end());
  return true;
}

Result<OusterFrameIndex> find_ouster_frames(const std::filesystem::path& path,
                                            const OusterPackets& packets) {
  FrameFinder finder(path, packets);
  SIGHTLINE_TRY(visit_packets(path, [&](const PcapPacket& packet) { return finder.add(packet); }));
  return finder.finish();
}

}  // namespace sightline
