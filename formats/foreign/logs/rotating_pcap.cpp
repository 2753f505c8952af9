#include "formats/foreign/logs/rotating_pcap.h"

#include <utility>

#include "formats/base/bytes.h"
#include "formats/base/check.h"
#include "formats/base/units.h"
#include "formats/foreign/logs/pcap_reader.h"

namespace sightline {
namespace {

// Where one revolution of a turning LiDAR lies in a pcap: from the block at which the azimuth
// falls back to the block before the next fall.
struct Revolution {
  std::uint64_t offset = 0;      // of the record of its first packet, bytes
  std::size_t packet_count = 0;  // data packets, none of them twice
  std::size_t first_block = 0;   // in its first packet
  std::size_t end_block = 0;     // in its last packet, behind its last block
  std::int64_t first_ns = 0;     // time of its first packet, of the sensor's clock
};

struct RevolutionIndex {
  std::vector<Revolution> revolutions;
  std::vector<ContainedScan> scans;  // one each; content: as begin_scan and store_packet put it
  std::vector<std::string> warnings;
};

// How a packet lies among the bytes of a scan: its absolute time, then what is read of its datagram
// (packet_size() of them). The LiDAR's calibration stands before the first.
ByteWriter begin_scan(const RotatingLidar& lidar) {
  ByteWriter bytes;
  const std::vector<std::byte> calibration = lidar.calibration();
  bytes.append(calibration.data(), calibration.size());
  return bytes;
}

void store_packet(const RotatingLidar& lidar, std::int64_t time_ns,
                  std::span<const std::byte> datagram, ByteWriter& bytes) {
  bytes.put(time_ns);
  bytes.append(datagram.data(), lidar.packet_size());
}

std::size_t stored_size(const RotatingLidar& lidar) {
  return sizeof(std::int64_t) + lidar.packet_size();
}

constexpr std::int64_t kHour_ns = 3600 * kSecond_ns;
// Packets follow each other after 0.5 to 1.4 ms. Where more is missing than this, a part of the
// revolution is.
constexpr std::int64_t kLongestGap_ns = kSecond_ns / 100;
constexpr std::int64_t kFirstSetClock_ns = 1'104'537'600 * kSecond_ns;  // 2005
// The slowest head turns 5 times a second.
constexpr std::int64_t kLongestTurn_ns = kSecond_ns;

class RevolutionFinder {
 public:
  RevolutionFinder(std::filesystem::path path, const RotatingLidar& lidar)
      : path_(std::move(path)), lidar_(lidar), clock_(lidar.has_date()) {}

  Result<void> add(const PcapPacket& packet) {
    if (!lidar_.is_data(packet.datagram)) {
      ++other_packets_;
      return {};
    }
    SIGHTLINE_TRY(check(packet));
    if (time_before_ns_ == time_ns_) {
      ++other_packets_;
      return {};
    }
    ++data_packets_;
    note_gap(packet);
    time_before_ns_ = time_ns_;
    // A packet belongs to the revolution that goes on unless its very first block begins the next,
    // and to each that begins in it.
    for (std::size_t block = 0; block < lidar_.block_count(); ++block) {
      const bool falls = is_fall(lidar_.azimuth_cdeg(packet.datagram, block));
      if (falls) {
        close_revolution(block);
        open_ = Revolution{packet.offset, 0, block, 0, time_ns_};
        open_offset_ns_ = lidar_.block_offset_ns(packet.datagram, block);
        bytes_ = begin_scan(lidar_);
      }
      if (falls || block == 0) store(packet);
    }
    return {};
  }

  Result<RevolutionIndex> finish() {
    if (index_.revolutions.empty()) {
      return error(ErrorCode::kDriveTooShort,
                   concat("no whole revolution of a ", lidar_.maker(), " sensor among ",
                          data_packets_, " data packets and ", other_packets_, " others"),
                   0);
    }
    warn();
    return std::move(index_);
  }

 private:
  Result<void> check(const PcapPacket& packet) {
    const Result<void> right = lidar_.check(packet.datagram);
    if (!right) return error(right.error().code, right.error().message, packet.offset);
    const int model = lidar_.model(packet.datagram);
    if (model != model_.value_or(model)) {
      return error(ErrorCode::kUnsupportedFormat,
                   concat("found packets of two models of ", lidar_.maker(),
                          "; keep those of one, for example with `tshark -r in.pcap -Y \"ip.src == "
                          "ADDRESS\" -w out.pcap`"),
                   packet.offset);
    }
    model_ = model;
    time_ns_ = clock_.absolute_ns(lidar_.time_ns(packet.datagram), packet.time_ns);
    if (time_before_ns_ && time_ns_ < *time_before_ns_) {
      return error(
          ErrorCode::kTimeRunsBackwards,
          concat("the sensor's clock jumps back by ", (*time_before_ns_ - time_ns_) / 1000, " us"),
          packet.offset);
    }
    return {};
  }

  void note_gap(const PcapPacket& packet) {
    const bool is_gap = time_before_ns_ && time_ns_ - *time_before_ns_ > kLongestGap_ns;
    if (is_gap && gaps_++ == 0) first_gap_offset_ = packet.offset;
    const bool stands_still = open_ && time_ns_ - open_->first_ns > kLongestTurn_ns;
    if (!is_gap && !stands_still) return;
    open_.reset();
    azimuth_before_cdeg_.reset();
  }

  // By more than half a turn; less is the head's jitter.
  bool is_fall(unsigned azimuth_cdeg) {
    constexpr unsigned kHalfTurn_cdeg = 18000;
    const bool falls =
        azimuth_before_cdeg_ && azimuth_cdeg + kHalfTurn_cdeg < *azimuth_before_cdeg_;
    azimuth_before_cdeg_ = azimuth_cdeg;
    return falls;
  }

  void close_revolution(std::size_t end_block) {
    if (open_) {
      open_->end_block = end_block == 0 ? lidar_.block_count() : end_block;
      index_.scans.push_back({open_->first_ns + open_offset_ns_, sha256(bytes_.bytes())});
      index_.revolutions.push_back(*open_);
    }
    open_.reset();
  }

  void store(const PcapPacket& packet) {
    if (!open_) return;
    ++open_->packet_count;
    store_packet(lidar_, time_ns_, packet.datagram, bytes_);
  }

  void warn() {
    const std::string name = path_.filename().string();
    index_.warnings.push_back(
        concat(name, ": ", index_.revolutions.size(), " whole revolutions in ", data_packets_,
               " data packets; the parts before the first and after the last were left out, and ",
               other_packets_, " packets of other kinds"));
    if (gaps_ > 0) {
      index_.warnings.push_back(
          concat(name, ": ", gaps_, " gaps of more than 10 ms between packets, the first at byte ",
                 first_gap_offset_, "; their revolutions were left out"));
    }
    if (clock_.is_shifted()) {
      index_.warnings.push_back(
          name +
          ": the sensor's clock was not set; times count from the capture of the first packet");
    }
    for (const std::string& warning : lidar_.warnings()) index_.warnings.push_back(warning);
  }

  [[nodiscard]] Error error(ErrorCode code, std::string message, std::uint64_t offset) const {
    return {code, std::move(message), path_.string(), concat("byte ", offset)};
  }

  std::filesystem::path path_;
  RevolutionIndex index_;
  const RotatingLidar& lidar_;
  PacketClock clock_;
  std::optional<Revolution> open_;   // the one that goes on
  ByteWriter bytes_;                 // its packets
  std::int64_t open_offset_ns_ = 0;  // of its first block, behind its first packet's time
  std::optional<unsigned> azimuth_before_cdeg_;
  std::optional<std::int64_t> time_before_ns_;
  std::int64_t time_ns_ = 0;
  std::optional<int> model_;
  std::uint64_t data_packets_ = 0;
  std::uint64_t other_packets_ = 0;
  std::uint64_t gaps_ = 0;
  std::uint64_t first_gap_offset_ = 0;
};

// Walks through the file once, holding one revolution. What stands before the first fall, behind
// the last or around a gap of more than 10 ms is no whole revolution; a packet with the time of the
// one before was captured twice. Errors: those of open_rotating_pcap.
Result<RevolutionIndex> find_revolutions(const std::filesystem::path& path,
                                         const RotatingLidar& lidar) {
  RevolutionFinder finder(path, lidar);
  SIGHTLINE_TRY(visit_packets(path, [&](const PcapPacket& packet) { return finder.add(packet); }));
  return finder.finish();
}

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

  Result<std::vector<std::byte>> read(std::size_t index) const override {
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
                     path_.string(), concat("byte ", revolution.offset)};
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

  Result<PointCloudFile> parse(std::span<const std::byte> bytes, std::size_t index) const override {
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

 private:
  std::filesystem::path path_;
  std::unique_ptr<const RotatingLidar> lidar_;
  std::vector<Revolution> revolutions_;
};

}  // namespace

std::int64_t PacketClock::of_hour(std::int64_t within_ns, std::int64_t near_ns) {
  if (!now_ns_) {
    const std::int64_t hours = (near_ns - within_ns + kHour_ns / 2) / kHour_ns;
    now_ns_ = hours * kHour_ns + within_ns;
    return *now_ns_;
  }
  std::int64_t step_ns = (within_ns - *now_ns_ % kHour_ns + kHour_ns) % kHour_ns;
  if (step_ns > kHour_ns / 2) step_ns -= kHour_ns;
  *now_ns_ += step_ns;
  return *now_ns_;
}

std::int64_t PacketClock::absolute_ns(std::int64_t packet_ns, std::int64_t near_ns) {
  if (!has_date_) return of_hour(packet_ns, near_ns);
  if (!shift_ns_) shift_ns_ = packet_ns < kFirstSetClock_ns ? near_ns - packet_ns : 0;
  return packet_ns + *shift_ns_;
}

Result<std::shared_ptr<const ScanContainer>> open_rotating_pcap(
    const std::filesystem::path& path, std::unique_ptr<const RotatingLidar> lidar) {
  SIGHTLINE_ASSIGN(RevolutionIndex index, find_revolutions(path, *lidar));
  return std::shared_ptr<const ScanContainer>(
      std::make_shared<RotatingPcap>(path, std::move(lidar), std::move(index)));
}

}  // namespace sightline
