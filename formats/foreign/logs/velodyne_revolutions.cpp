#include "formats/foreign/logs/velodyne_revolutions.h"

#include <utility>

#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/velodyne_packet.h"

namespace sightline {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kHour_ns = 3600 * kSecond_ns;
// Packets follow each other after 0.5 to 1.4 ms. Where more is missing than this, a part of the
// revolution is.
constexpr std::int64_t kLongestGap_ns = kSecond_ns / 100;
// The slowest head turns 5 times a second.
constexpr std::int64_t kLongestTurn_ns = kSecond_ns;

class RevolutionFinder {
 public:
  explicit RevolutionFinder(std::filesystem::path path) : path_(std::move(path)) {}

  Result<void> add(const PcapPacket& packet);
  Result<RevolutionIndex> finish();

 private:
  Result<void> check(const PcapPacket& packet, const VelodynePacket& data);
  void note_gap(const PcapPacket& packet);
  bool is_fall(unsigned azimuth_cdeg);
  void close_revolution(std::size_t end_block);
  void store(const PcapPacket& packet);
  void warn();
  [[nodiscard]] Error error(ErrorCode code, std::string message, std::uint64_t offset) const {
    return {code, std::move(message), path_.string(), "byte " + std::to_string(offset)};
  }

  std::filesystem::path path_;
  RevolutionIndex index_;
  HourClock clock_;
  std::optional<Revolution> open_;  // the one that goes on
  ByteWriter bytes_;                // its packets
  std::optional<unsigned> azimuth_before_cdeg_;
  std::optional<std::int64_t> time_before_ns_;
  std::int64_t time_ns_ = 0;
  std::optional<int> product_id_;
  std::uint64_t data_packets_ = 0;
  std::uint64_t other_packets_ = 0;
  std::uint64_t gaps_ = 0;
  std::uint64_t first_gap_offset_ = 0;
};

Result<void> RevolutionFinder::check(const PcapPacket& packet, const VelodynePacket& data) {
  if (!data.is_valid()) {
    return error(ErrorCode::kMalformedHeader,
                 "found 1206 bytes of UDP that are no Velodyne data packet", packet.offset);
  }
  if (!data.model() || data.product_id() != product_id_.value_or(data.product_id())) {
    return error(ErrorCode::kUnsupportedFormat,
                 "found product id " + std::to_string(data.product_id()) +
                     ", expected packets of one HDL-32E (33) or VLP-16 (34); export the scans as "
                     "PCD with the sensor's own tools",
                 packet.offset);
  }
  product_id_ = data.product_id();
  time_ns_ = clock_.absolute_ns(data.hour_us(), packet.time_ns);
  if (time_before_ns_ && time_ns_ < *time_before_ns_) {
    return error(ErrorCode::kTimeRunsBackwards,
                 "the sensor's clock goes back by " +
                     std::to_string((*time_before_ns_ - time_ns_) / 1000) + " us",
                 packet.offset);
  }
  return {};
}

void RevolutionFinder::note_gap(const PcapPacket& packet) {
  const bool is_gap = time_before_ns_ && time_ns_ - *time_before_ns_ > kLongestGap_ns;
  if (is_gap && gaps_++ == 0) first_gap_offset_ = packet.offset;
  const bool stands_still = open_ && time_ns_ - open_->first_ns > kLongestTurn_ns;
  if (!is_gap && !stands_still) return;
  open_.reset();
  azimuth_before_cdeg_.reset();
}

// By more than half a turn; less is the head's jitter.
bool RevolutionFinder::is_fall(unsigned azimuth_cdeg) {
  constexpr unsigned kHalfTurn_cdeg = 18000;
  const bool falls = azimuth_before_cdeg_ && azimuth_cdeg + kHalfTurn_cdeg < *azimuth_before_cdeg_;
  azimuth_before_cdeg_ = azimuth_cdeg;
  return falls;
}

void RevolutionFinder::close_revolution(std::size_t end_block) {
  if (open_) {
    open_->end_block = end_block == 0 ? kVelodyneBlocks : end_block;
    const std::span<const std::byte> packets = bytes_.bytes();
    const VelodynePacket first(packets.subspan(sizeof(std::int64_t), kVelodynePacketSize));
    index_.scans.push_back(
        {open_->first_ns + first.block_offset_ns(open_->first_block), sha256(packets)});
    index_.revolutions.push_back(*open_);
  }
  open_.reset();
}

void RevolutionFinder::store(const PcapPacket& packet) {
  if (!open_) return;
  ++open_->packet_count;
  store_packet(time_ns_, packet.datagram, bytes_);
}

Result<void> RevolutionFinder::add(const PcapPacket& packet) {
  if (packet.datagram.size() != kVelodynePacketSize) {
    ++other_packets_;
    return {};
  }
  const VelodynePacket data(packet.datagram);
  SIGHTLINE_TRY(check(packet, data));
  if (time_before_ns_ == time_ns_) {
    ++other_packets_;
    return {};
  }
  ++data_packets_;
  note_gap(packet);
  time_before_ns_ = time_ns_;
  // A packet belongs to the revolution that goes on unless its very first block begins the next,
  // and to each that begins in it.
  for (std::size_t block = 0; block < kVelodyneBlocks; ++block) {
    const bool falls = is_fall(data.azimuth_cdeg(block));
    if (falls) {
      close_revolution(block);
      open_ = Revolution{packet.offset, 0, block, 0, time_ns_};
      bytes_ = ByteWriter();
    }
    if (falls || block == 0) store(packet);
  }
  return {};
}

void RevolutionFinder::warn() {
  const std::string name = path_.filename().string();
  index_.warnings.push_back(name + ": " + std::to_string(index_.revolutions.size()) +
                            " whole revolutions in " + std::to_string(data_packets_) +
                            " data packets; the parts before the first and behind the last were "
                            "left out, and " +
                            std::to_string(other_packets_) + " packets of other kinds");
  if (gaps_ > 0) {
    index_.warnings.push_back(name + ": " + std::to_string(gaps_) +
                              " gaps of more than 10 ms between packets, the first at byte " +
                              std::to_string(first_gap_offset_) +
                              "; their revolutions were left out");
  }
}

Result<RevolutionIndex> RevolutionFinder::finish() {
  if (index_.revolutions.empty()) {
    return error(ErrorCode::kDriveTooShort,
                 "no whole revolution of a Velodyne sensor among " + std::to_string(data_packets_) +
                     " data packets and " + std::to_string(other_packets_) + " others",
                 0);
  }
  warn();
  return std::move(index_);
}

}  // namespace

std::int64_t HourClock::absolute_ns(std::uint32_t hour_us, std::int64_t near_ns) {
  const std::int64_t within_ns = std::int64_t{hour_us} * 1000;
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

void store_packet(std::int64_t time_ns, std::span<const std::byte> datagram, ByteWriter& bytes) {
  bytes.put(time_ns);
  bytes.append(datagram.data(), datagram.size());
}

Result<RevolutionIndex> find_revolutions(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path));
  RevolutionFinder finder(path);
  PcapPacket packet;
  while (true) {
    SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
    if (!more) return finder.finish();
    SIGHTLINE_TRY(finder.add(packet));
  }
}

}  // namespace sightline
