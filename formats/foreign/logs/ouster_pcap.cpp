#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/check.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/portable_math.h"
#include "formats/base/result.h"
#include "formats/base/units.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/logs/open_capture.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/rotating_pcap.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/ouster_metadata.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

// Lidar data packets of Ouster's sensors as the Software User Manual describes them: a header,
// columns of one time and one turn of the head, a footer. A column has a return or two of every
// beam.

// Where things lie in the packets of one profile.
struct OusterLayout {
  struct Return {
    std::size_t range_at = 0;  // in its pixel, bytes
    std::uint32_t range_mask = 0;
    std::size_t range_size = 4;
    double tick_m = 0.001;
    std::size_t reflectivity_at = 0;
  };
  std::string profile;  // LEGACY, RNG19_RFL8_SIG16_NIR16, ...
  bool is_legacy = false;
  std::size_t pixel_size = 0;
  std::vector<Return> returns;
};

class OusterPackets {
 public:
  // Errors without a file: missing-field (the metadata lacks columns, azimuths or transforms),
  // unsupported-format (another profile; says how to convert it), bad-value (packets longer than
  // UDP allows).
  static Result<OusterPackets> of(const OusterMetadata& metadata);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t column_count() const { return metadata_.columns_per_packet; }
  [[nodiscard]] std::size_t columns_per_frame() const { return metadata_.columns_per_frame; }
  // Packets of a frame, from the first column to the last one that is sent.
  [[nodiscard]] std::size_t packets_per_frame() const { return packets_per_frame_; }

  // Of the right size, and lidar data as far as that is said. The others below need it.
  [[nodiscard]] bool is_data(std::span<const std::byte> datagram) const;
  [[nodiscard]] std::uint16_t frame_id(std::span<const std::byte> packet) const;

  // Of one column. Whether it was measured, and belongs to the packet's frame.
  [[nodiscard]] bool is_valid(std::span<const std::byte> packet, std::size_t column) const;
  [[nodiscard]] std::size_t measurement_id(std::span<const std::byte> packet,
                                           std::size_t column) const;
  // By the sensor's clock; at most 2^62.
  [[nodiscard]] std::int64_t time_ns(std::span<const std::byte> packet, std::size_t column) const;

  // Adds the returns of a valid column, which was measured `time_offset_ns` after the scan's stamp.
  // Axes: the sensor frame of the manual, x forward, z up. Intensity: reflectivity, 0 .. 255. A
  // range of 0 is no return (zero_count), nor is a second one equal to the first.
  void append_column(std::span<const std::byte> packet, std::size_t column,
                     std::int32_t time_offset_ns, PointCloudFile& cloud) const;

  // All that decides where points lie, for digests.
  [[nodiscard]] std::vector<std::byte> calibration() const;

 private:
  OusterPackets(OusterMetadata metadata, OusterLayout layout);
  [[nodiscard]] std::size_t column_at(std::size_t column) const;

  OusterMetadata metadata_;
  OusterLayout layout_;
  Eigen::Matrix3d R_sensor_lidar_;
  Eigen::Vector3d t_sensor_lidar_m_;
  std::size_t column_size_ = 0;
  std::size_t size_ = 0;
  std::size_t packets_per_frame_ = 0;
};

// Legacy packets have no header; each column ends with a word that says whether it is whole. The
// others have a header and a footer of 32 bytes each, and say it in the column's header.
constexpr std::size_t kHeader = 32;
constexpr std::size_t kFooter = 32;
constexpr std::size_t kLegacyColumnHeader = 16;
constexpr std::size_t kLegacyColumnFooter = 4;
constexpr std::size_t kColumnHeader = 12;
constexpr std::uint32_t kLegacyValid = 0xffffffff;
constexpr std::uint16_t kLidarPacket = 1;
constexpr std::size_t kLargestDatagram = 65507;
constexpr std::uint32_t k15Bits = 0x7fff;
constexpr std::uint32_t k19Bits = 0x7ffff;
constexpr std::uint32_t k20Bits = 0xfffff;

// Software User Manual, "Lidar Data Format".
const std::array<OusterLayout, 4>& layouts() {
  static const std::array<OusterLayout, 4> all = {{
      {"LEGACY", true, 12, {{0, k20Bits, 4, 0.001, 4}}},
      {"RNG19_RFL8_SIG16_NIR16", false, 12, {{0, k19Bits, 4, 0.001, 4}}},
      {"RNG19_RFL8_SIG16_NIR16_DUAL",
       false,
       16,
       {{0, k19Bits, 4, 0.001, 3}, {4, k19Bits, 4, 0.001, 7}}},
      {"RNG15_RFL8_NIR8", false, 4, {{0, k15Bits, 2, 0.008, 2}}},
  }};
  return all;
}

std::uint32_t range_ticks(std::span<const std::byte> bytes, std::size_t pixel_at,
                          const OusterLayout::Return& part) {
  const std::size_t at = pixel_at + part.range_at;
  const std::uint32_t word =
      part.range_size == 2 ? read_at<std::uint16_t>(bytes, at) : read_at<std::uint32_t>(bytes, at);
  return word & part.range_mask;
}

// The profiles that are read, one space apart, for messages.
std::string ouster_profile_names() {
  std::string names;
  for (const OusterLayout& layout : layouts()) names += (names.empty() ? "" : " ") + layout.profile;
  return names;
}

Result<OusterLayout> layout_of(const std::string& profile) {
  for (const OusterLayout& layout : layouts()) {
    if (layout.profile == profile) return layout;
  }
  return Error{ErrorCode::kUnsupportedFormat,
               concat("found the profile ", profile, ", expected one of ", ouster_profile_names(),
                      "; convert it with `ouster-cli source CAPTURE save scans.bag`")};
}

OusterPackets::OusterPackets(OusterMetadata metadata, OusterLayout layout)
    : metadata_(std::move(metadata)), layout_(std::move(layout)) {
  constexpr double kMillimetre_m = 0.001;
  const Eigen::Matrix4d& to_sensor = *metadata_.lidar_to_sensor;
  R_sensor_lidar_ = to_sensor.topLeftCorner<3, 3>();
  t_sensor_lidar_m_ = kMillimetre_m * to_sensor.topRightCorner<3, 1>();
  const std::size_t pixels = metadata_.altitudes_deg.size() * layout_.pixel_size;
  column_size_ = layout_.is_legacy ? kLegacyColumnHeader + pixels + kLegacyColumnFooter
                                   : kColumnHeader + pixels;
  size_ = metadata_.columns_per_packet * column_size_ + (layout_.is_legacy ? 0 : kHeader + kFooter);
  // A window may go through column 0.
  const std::size_t columns = metadata_.columns_per_frame;
  const std::size_t step = metadata_.columns_per_packet;
  const std::size_t first = metadata_.first_column / step;
  const std::size_t last = metadata_.last_column / step;
  const std::size_t all = (columns + step - 1) / step;
  packets_per_frame_ = std::min(all, (last >= first ? last : last + all) - first + 1);
}

Result<OusterPackets> OusterPackets::of(const OusterMetadata& metadata) {
  const auto lacks = [](const std::string& what) {
    return Error{ErrorCode::kMissingField, "the metadata lacks " + what};
  };
  if (metadata.azimuths_deg.empty()) return lacks("beam_azimuth_angles");
  if (metadata.columns_per_frame == 0) return lacks("columns_per_frame");
  if (!metadata.beam_radius_mm) return lacks("lidar_origin_to_beam_origin_mm");
  if (!metadata.lidar_to_sensor) return lacks("lidar_to_sensor_transform");
  Pose to_sensor = Pose::Identity();
  to_sensor.linear() = metadata.lidar_to_sensor->topLeftCorner<3, 3>();
  if (!is_rigid(to_sensor)) {
    return Error{ErrorCode::kBadValue,
                 "lidar_to_sensor_transform is not a rotation and translation"};
  }
  SIGHTLINE_ASSIGN(OusterLayout layout, layout_of(metadata.profile));
  OusterPackets packets(metadata, std::move(layout));
  if (packets.size_ <= kLargestDatagram) return packets;
  return Error{ErrorCode::kBadValue,
               concat("packets of ", packets.size_, " bytes are longer than UDP allows")};
}

bool OusterPackets::is_data(std::span<const std::byte> datagram) const {
  if (datagram.size() != size_) return false;
  return layout_.is_legacy || read_at<std::uint16_t>(datagram, 0) == kLidarPacket;
}

std::size_t OusterPackets::column_at(std::size_t column) const {
  return (layout_.is_legacy ? 0 : kHeader) + column * column_size_;
}

std::uint16_t OusterPackets::frame_id(std::span<const std::byte> packet) const {
  return read_at<std::uint16_t>(packet, layout_.is_legacy ? 10 : 2);
}

bool OusterPackets::is_valid(std::span<const std::byte> packet, std::size_t column) const {
  const std::size_t at = column_at(column);
  if (measurement_id(packet, column) >= metadata_.columns_per_frame) return false;
  if (!layout_.is_legacy) return (read_at<std::uint16_t>(packet, at + 10) & 1U) != 0;
  return read_at<std::uint16_t>(packet, at + 10) == frame_id(packet) &&
         read_at<std::uint32_t>(packet, at + column_size_ - kLegacyColumnFooter) == kLegacyValid;
}

std::size_t OusterPackets::measurement_id(std::span<const std::byte> packet,
                                          std::size_t column) const {
  return read_at<std::uint16_t>(packet, column_at(column) + 8);
}

std::int64_t OusterPackets::time_ns(std::span<const std::byte> packet, std::size_t column) const {
  constexpr std::uint64_t kMost_ns = std::uint64_t{1} << 62U;
  return static_cast<std::int64_t>(
      std::min(kMost_ns, read_at<std::uint64_t>(packet, column_at(column))));
}

// Software User Manual, "Lidar Range to XYZ": the beam leaves a point that turns with the head, and
// the range counts from the axis along the way of the light.
void OusterPackets::append_column(std::span<const std::byte> packet, std::size_t column,
                                  std::int32_t time_offset_ns, PointCloudFile& cloud) const {
  constexpr double kMillimetre_m = 0.001;
  const double turn = static_cast<double>(measurement_id(packet, column)) /
                      static_cast<double>(metadata_.columns_per_frame);
  const double encoder_rad = 2.0 * std::numbers::pi * (1.0 - turn);
  const double radius_m = kMillimetre_m * *metadata_.beam_radius_mm;
  const double height_m = kMillimetre_m * metadata_.beam_height_mm;
  const double lead_m = height_m == 0.0 ? radius_m : portable_hypot(radius_m, height_m);
  const SinCos encoder = portable_sin_cos(encoder_rad);
  const Eigen::Vector3d origin_m(radius_m * encoder.cos, radius_m * encoder.sin, height_m);
  const std::size_t first_pixel_at =
      column_at(column) + (layout_.is_legacy ? kLegacyColumnHeader : kColumnHeader);
  for (std::size_t beam = 0; beam < metadata_.altitudes_deg.size(); ++beam) {
    const std::size_t pixel_at = first_pixel_at + beam * layout_.pixel_size;
    const Eigen::Vector3d direction =
        direction_of(encoder_rad - kRadPerDeg * metadata_.azimuths_deg[beam],
                     kRadPerDeg * metadata_.altitudes_deg[beam]);
    std::uint32_t before = 0;
    for (const OusterLayout::Return& part : layout_.returns) {
      const std::uint32_t ticks = range_ticks(packet, pixel_at, part);
      if (ticks == 0 || ticks == before) {
        ++cloud.zero_count;
        continue;
      }
      before = ticks;
      const Eigen::Vector3d p_lidar_m = (part.tick_m * ticks - lead_m) * direction + origin_m;
      const auto reflectivity =
          static_cast<float>(std::to_integer<int>(packet[pixel_at + part.reflectivity_at]));
      if (add_point(cloud, R_sensor_lidar_ * p_lidar_m + t_sensor_lidar_m_, reflectivity)) {
        cloud.time_offset_ns.push_back(time_offset_ns);
      }
    }
  }
}

std::vector<std::byte> OusterPackets::calibration() const {
  ByteWriter bytes;
  bytes.put_string(metadata_.profile);
  bytes.put<std::uint64_t>(metadata_.columns_per_frame);
  bytes.put_array(metadata_.altitudes_deg);
  bytes.put_array(metadata_.azimuths_deg);
  bytes.put(*metadata_.beam_radius_mm);
  bytes.put(metadata_.beam_height_mm);
  for (const double value : metadata_.lidar_to_sensor->reshaped()) bytes.put(value);
  return bytes.take();
}

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

  Result<void> add(const PcapPacket& packet) {
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

  Result<OusterFrameIndex> finish() {
    SIGHTLINE_TRY(close());
    if (index_.frames.empty()) {
      return error(ErrorCode::kDriveTooShort,
                   concat("no whole frame of an Ouster sensor among ", data_packets_,
                          " data packets of ", packets_.size(), " bytes and ", other_packets_,
                          " others. A capture of several sensors is not read: keep one sensor, for "
                          "example with `tshark -r in.pcap -Y \"ip.src == ADDRESS\" -w out.pcap`"),
                   0);
    }
    warn();
    return std::move(index_);
  }

 private:
  Result<void> check(const PcapPacket& packet) {
    for (std::size_t column = 0; column < packets_.column_count(); ++column) {
      const std::size_t id = packets_.measurement_id(packet.datagram, column);
      if (id < packets_.columns_per_frame()) continue;
      return error(
          ErrorCode::kMismatchedInputs,
          concat("found column ", id, ", but the metadata has ", packets_.columns_per_frame(),
                 " a frame: the metadata is of another sensor or mode"),
          packet.offset);
    }
    return {};
  }

  Result<void> close() {
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
                     concat("the sensor's clock jumps back by ",
                            (index_.scans.back().stamp_ns - stamp_ns) / 1000, " us"),
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

  void warn() {
    const std::string name = path_.filename().string();
    index_.warnings.push_back(
        concat(name, ": ", index_.frames.size(), " frames in ", data_packets_, " data packets; ",
               left_out_, " frames that lack more than a tenth were left out, and ", other_packets_,
               " packets that are of other kinds, late or repeated"));
    if (missing_ > 0) {
      index_.warnings.push_back(concat(name, ": ", missing_, " packets of the frames are missing"));
    }
    if (clock_.is_shifted()) {
      index_.warnings.push_back(
          name +
          ": the sensor's clock was not set; times count from the capture of the first packet");
    }
  }

  [[nodiscard]] Error error(ErrorCode code, std::string message, std::uint64_t offset) const {
    return {code, std::move(message), path_.string(), concat("byte ", offset)};
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

// Walks through the file once, holding one frame. A frame that lacks more than a tenth of its
// packets, spans over a second or was not measured is left out and counted. Stamps are the
// sensor's; where its clock counts from its start (before 2005), from the first packet's capture.
// Errors: those of PcapReader, mismatched-inputs, time-runs-backwards, drive-too-short (no frame).
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

  Result<std::vector<std::byte>> read(std::size_t index) const override {
    const OusterFrame& frame = frames_.at(index);
    SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path_));
    reader.seek(frame.offset);
    OusterFramePackets collected(packets_);
    PcapPacket packet;
    while (collected.count() < frame.packet_count) {
      SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
      if (!more) {
        return Error{ErrorCode::kCannotRead, "the file has become shorter since it was opened",
                     path_.string(), concat("byte ", frame.offset)};
      }
      if (!packets_.is_data(packet.datagram)) continue;
      if (packets_.frame_id(packet.datagram) == frame.frame_id) collected.add(packet.datagram);
    }
    return collected.bytes();
  }

  Result<PointCloudFile> parse(std::span<const std::byte> bytes, std::size_t index) const override {
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

 private:
  std::filesystem::path path_;
  OusterPackets packets_;
  std::vector<OusterFrame> frames_;
};

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
