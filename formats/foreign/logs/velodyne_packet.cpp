#include "formats/foreign/logs/velodyne_packet.h"

#include <array>
#include <cmath>

#include "formats/base/check.h"
#include "formats/base/units.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

constexpr std::size_t kBlockSize = 100;
constexpr std::size_t kReturns = 32;
constexpr std::size_t kReturnSize = 3;
constexpr std::size_t kTimeAt = 1200;
constexpr std::size_t kModeAt = 1204;
constexpr std::size_t kProductAt = 1205;
constexpr std::uint16_t kBlockFlag = 0xeeff;  // FF EE as they lie
constexpr int kDualMode = 0x39;
constexpr int kHdl32eId = 0x21;
constexpr int kVlp16Id = 0x22;
constexpr double kTick_m = 0.002;

// How the lasers of a model fire and where they look; manuals, sections on firing sequences.
struct Optics {
  std::size_t lasers = 0;
  double laser_us = 0.0;     // from one laser to the next
  double sequence_us = 0.0;  // from the first laser to the first again
};
constexpr Optics kVlp16Optics = {16, 2.304, 55.296};
constexpr Optics kHdl32eOptics = {32, 1.152, 46.080};

// VLP-16 manual, laser IDs, vertical angles and vertical corrections.
constexpr std::array<double, 16> kVlp16Elevations_deg = {-15, 1, -13, 3,  -11, 5,  -9, 7,
                                                         -7,  9, -5,  11, -3,  13, -1, 15};
constexpr std::array<double, 16> kVlp16Lifts_m = {0.0112, -0.0007, 0.0097, -0.0022, 0.0081, -0.0037,
                                                  0.0066, -0.0051, 0.0051, -0.0066, 0.0037, -0.0081,
                                                  0.0022, -0.0097, 0.0007, -0.0112};

// HDL-32E manual: lasers 4/3 degrees apart, fired from the lower and the upper half in turn.
double hdl32e_elevation_deg(std::size_t laser) {
  constexpr double kLowest_deg = -92.0 / 3.0;
  constexpr double kStep_deg = 4.0 / 3.0;
  return kLowest_deg + kStep_deg * static_cast<double>(laser / 2 + 16 * (laser % 2));
}

const Optics& optics_of(VelodyneModel model) {
  return model == VelodyneModel::kVlp16 ? kVlp16Optics : kHdl32eOptics;
}

std::int64_t whole_ns(double us) { return std::llround(1e3 * us); }

// Where a return is: the manuals' formula with x forward (their y) and y left (their -x).
Eigen::Vector3d position_m(VelodyneModel model, std::size_t laser, double azimuth_deg,
                           double distance_m) {
  const bool is_vlp16 = model == VelodyneModel::kVlp16;
  const double elevation_rad =
      kRadPerDeg * (is_vlp16 ? kVlp16Elevations_deg[laser] : hdl32e_elevation_deg(laser));
  const double azimuth_rad = kRadPerDeg * azimuth_deg;
  const Eigen::Vector3d from_laser_m = distance_m * direction_of(-azimuth_rad, elevation_rad);
  return from_laser_m + (is_vlp16 ? kVlp16Lifts_m[laser] : 0.0) * Eigen::Vector3d::UnitZ();
}

class VelodyneLidar : public RotatingLidar {
 public:
  [[nodiscard]] std::string maker() const override { return "Velodyne"; }
  [[nodiscard]] bool is_data(std::span<const std::byte> datagram) const override {
    return datagram.size() == kVelodynePacketSize;
  }
  [[nodiscard]] std::size_t packet_size() const override { return kVelodynePacketSize; }

  [[nodiscard]] Result<void> check(std::span<const std::byte> bytes) const override {
    const VelodynePacket packet(bytes);
    if (!packet.is_valid()) {
      return Error{ErrorCode::kMalformedHeader,
                   "found 1206 bytes of UDP that are not a Velodyne data packet"};
    }
    if (packet.model()) return {};
    return Error{
        ErrorCode::kUnsupportedFormat,
        concat("found product id ", packet.product_id(),
               ", expected packets of one HDL-32E (33) or VLP-16 (34); export the scans as "
               "PCD with the sensor's own tools")};
  }

  [[nodiscard]] int model(std::span<const std::byte> bytes) const override {
    return VelodynePacket(bytes).product_id();
  }
  [[nodiscard]] std::size_t block_count() const override { return kVelodyneBlocks; }
  [[nodiscard]] unsigned azimuth_cdeg(std::span<const std::byte> bytes,
                                      std::size_t block) const override {
    return VelodynePacket(bytes).azimuth_cdeg(block);
  }
  [[nodiscard]] std::int64_t time_ns(std::span<const std::byte> bytes) const override {
    return std::int64_t{VelodynePacket(bytes).hour_us()} * 1000;
  }
  [[nodiscard]] bool has_date() const override { return false; }
  [[nodiscard]] std::int64_t block_offset_ns(std::span<const std::byte> bytes,
                                             std::size_t block) const override {
    return VelodynePacket(bytes).block_offset_ns(block);
  }
  void append_block(std::span<const std::byte> bytes, std::size_t block, std::int64_t base_ns,
                    PointCloudFile& cloud) const override {
    VelodynePacket(bytes).append_block(block, base_ns, cloud);
  }
};

}  // namespace

VelodynePacket::VelodynePacket(std::span<const std::byte> bytes) : bytes_(bytes) {
  SIGHTLINE_CHECK(bytes.size() == kVelodynePacketSize);
}

bool VelodynePacket::is_valid() const {
  for (std::size_t block = 0; block < kVelodyneBlocks; ++block) {
    if (read_at<std::uint16_t>(bytes_, block * kBlockSize) != kBlockFlag) return false;
    if (azimuth_cdeg(block) >= 36000U) return false;
  }
  return hour_us() < 3'600'000'000U;
}

int VelodynePacket::product_id() const { return std::to_integer<int>(bytes_[kProductAt]); }

std::optional<VelodyneModel> VelodynePacket::model() const {
  if (product_id() == kVlp16Id) return VelodyneModel::kVlp16;
  if (product_id() == kHdl32eId) return VelodyneModel::kHdl32e;
  return std::nullopt;
}

std::uint32_t VelodynePacket::hour_us() const { return read_at<std::uint32_t>(bytes_, kTimeAt); }

unsigned VelodynePacket::azimuth_cdeg(std::size_t block) const {
  return read_at<std::uint16_t>(bytes_, block * kBlockSize + 2);
}

bool VelodynePacket::is_dual() const { return std::to_integer<int>(bytes_[kModeAt]) == kDualMode; }

std::int64_t VelodynePacket::block_offset_ns(std::size_t block) const {
  const Optics& optics = optics_of(*model());
  const std::size_t turn = is_dual() ? block / 2 : block;
  return whole_ns(static_cast<double>(turn * (kReturns / optics.lasers)) * optics.sequence_us);
}

// How far the head turns while a block is measured. The last one has no next: it takes the step
// before.
double VelodynePacket::azimuth_step_cdeg(std::size_t block) const {
  constexpr unsigned kTurn = 36000;
  constexpr unsigned kMost = 300;  // over 20 Hz, or packets that do not belong together
  const std::size_t stride = is_dual() ? 2 : 1;
  const std::size_t from = block + stride < kVelodyneBlocks ? block : block - stride;
  const unsigned step = (azimuth_cdeg(from + stride) + kTurn - azimuth_cdeg(from)) % kTurn;
  return step <= kMost ? step : 0.0;
}

void VelodynePacket::append_block(std::size_t block, std::int64_t base_ns,
                                  PointCloudFile& cloud) const {
  const VelodyneModel kind = *model();
  const Optics& optics = optics_of(kind);
  const double block_us = static_cast<double>(kReturns / optics.lasers) * optics.sequence_us;
  const double step_cdeg = azimuth_step_cdeg(block);
  const std::size_t first = block * kBlockSize + 4;
  for (std::size_t i = 0; i < kReturns; ++i) {
    const std::size_t at = first + i * kReturnSize;
    const auto ticks = read_at<std::uint16_t>(bytes_, at);
    const bool is_repeated =
        is_dual() && block % 2 == 1 && ticks == read_at<std::uint16_t>(bytes_, at - kBlockSize);
    if (ticks == 0 || is_repeated) {
      ++cloud.zero_count;
      continue;
    }
    const std::size_t laser = i % optics.lasers;
    const double after_us = static_cast<double>(i / optics.lasers) * optics.sequence_us +
                            static_cast<double>(laser) * optics.laser_us;
    const double azimuth_deg = 0.01 * (azimuth_cdeg(block) + step_cdeg * after_us / block_us);
    add_point(cloud, position_m(kind, laser, azimuth_deg, kTick_m * ticks),
              static_cast<float>(std::to_integer<int>(bytes_[at + 2])));
    cloud.time_offset_ns.push_back(
        static_cast<std::int32_t>(base_ns + block_offset_ns(block) + whole_ns(after_us)));
  }
}

Result<std::shared_ptr<const ScanContainer>> open_velodyne_pcap(const std::filesystem::path& path) {
  return open_rotating_pcap(path, std::make_unique<VelodyneLidar>());
}

}  // namespace sightline
