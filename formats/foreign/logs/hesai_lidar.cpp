#include "formats/foreign/logs/hesai_lidar.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/check.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/units.h"
#include "formats/drive/sensor_profile.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/sensor_file.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

// How the packets of Hesai's models are laid out and their lasers fire; User Manuals, chapter "Data
// structure" and appendices "Absolute time" and "Channel distribution".

struct HesaiAngles {
  double elevation_deg = 0.0;
  double azimuth_deg = 0.0;  // clockwise, beside that of the head
};

struct HesaiModel {
  std::string_view name;
  std::string_view profile;       // of formats/drive/sensor_profile.h
  std::uint8_t bytes_2_and_3[2];  // behind EE FF: channels and blocks, or the version
  std::size_t header_size = 0;
  std::size_t unit_at = 0;  // in the header: of a tick of distance, mm
  std::size_t channels = 0;
  std::size_t blocks = 0;
  std::size_t return_size = 0;  // distance u16, reflectivity u8, and what is not read
  // In the tail.
  std::size_t mode_at = 0;
  std::size_t date_at = 0;
  std::size_t us_at = 0;
  std::size_t tail_size = 0;
  int first_year = 0;
  // Of the last block, after the packet's time; of a block before.
  double last_block_us = 0.0;
  double block_us = 0.0;
  double firing_step_us = 0.0;  // from a channel to the next; 0: they fire in another order
  // Of a model whose packets have optional parts: which of them (bits of the header's last byte)
  // this one has, and of which that is asked.
  std::uint8_t parts = 0;
  std::uint8_t asked_parts = 0;
  std::size_t gap_size = 0;  // between the blocks and the tail
  // In the tail, of a model that says them; 0: it does not.
  std::size_t state_at = 0;  // operational state, 0: high resolution, twice as many blocks a turn
  std::size_t speed_at = 0;  // revolutions a minute, u16
  bool needs_correction = false;  // its nominal azimuths are not known here

  [[nodiscard]] std::size_t block_size() const { return 2 + channels * return_size; }
  [[nodiscard]] std::size_t tail_begin() const {
    return header_size + blocks * block_size() + gap_size;
  }
  [[nodiscard]] std::size_t packet_size() const { return tail_begin() + tail_size; }
};

// A Pandar128 of protocol 1.4: `parts` are functional safety (4) and confidences of returns (16).
constexpr HesaiModel pandar128(std::uint8_t parts) {
  constexpr std::size_t kChecksum = 4;
  constexpr std::size_t kSafety = 17;
  HesaiModel model{"Pandar128", "pandar128", {1, 4}, 12, 9, 128, 2};
  model.return_size = (parts & 16U) != 0 ? 4 : 3;
  model.gap_size = kChecksum + ((parts & 4U) != 0 ? kSafety : 0);
  model.state_at = 11;
  model.mode_at = 12;
  model.speed_at = 13;
  model.date_at = 15;
  model.us_at = 21;
  model.tail_size = 26;
  model.first_year = 1900;
  model.last_block_us = 3.148;
  model.block_us = 55.556;
  model.parts = parts;
  model.asked_parts = 4 | 16;
  model.needs_correction = true;
  return model;
}

constexpr std::array<HesaiModel, 7> kModels = {{
    {"Pandar64", "pandar64", {64, 6}, 8, 5, 64, 6, 3, 14, 16, 10, 22, 2000, -42.58, 55.56, 0.0},
    {"PandarXT-32", "xt32", {6, 1}, 12, 9, 32, 8, 4, 10, 13, 19, 24, 1900, 0.0, 50.0, 1.512},
    {"PandarXT-16", "xt16", {6, 1}, 12, 9, 16, 8, 4, 10, 13, 19, 24, 1900, 0.0, 50.0, 3.024},
    pandar128(0),
    pandar128(4),
    pandar128(16),
    pandar128(4 | 16),
}};

// Pandar64 User Manual: channels fire in turns of two, 1.3 or 2 us apart, and the block's time is
// the end of the turn. Here, microseconds before it.
constexpr std::array<double, 64> kPandar64Lead_us = {
    23.180, 21.876, 20.572, 19.268, 17.964, 16.660, 11.444, 46.796, 7.532,  36.956, 50.732,
    54.668, 40.892, 44.828, 31.052, 34.988, 48.764, 52.700, 38.924, 42.860, 29.084, 33.020,
    46.796, 25.148, 36.956, 50.732, 27.116, 40.892, 44.828, 31.052, 34.988, 48.764, 25.148,
    38.924, 42.860, 29.084, 33.020, 52.700, 6.228,  54.668, 15.356, 27.116, 10.140, 23.180,
    4.924,  21.876, 14.052, 17.964, 8.836,  19.268, 3.620,  20.572, 12.748, 16.660, 7.532,
    11.444, 6.228,  15.356, 10.140, 4.924,  3.620,  14.052, 8.836,  12.748};

// Pandar128 User Manual, "Laser firing time": in standard mode, of azimuth flag 0 and far returns.
// With another flag lasers fire up to 0.7 us earlier. Some fire again up to 17 us later for what is
// within 2.85 m, where 0.06 degrees at 10 Hz are 3 mm.
constexpr std::array<double, 128> kPandar128Firing_us = {
    4.436,  28.554, 0.776,  2.431,  4.436,  30.559, 6.441,  32.564, 34.219, 0.776,  2.431,  6.441,
    28.554, 34.219, 30.559, 28.554, 32.564, 6.441,  32.564, 0.776,  2.431,  30.559, 34.219, 32.564,
    4.436,  38.509, 43.079, 12.666, 43.079, 19.521, 19.521, 36.224, 12.666, 12.666, 38.509, 52.219,
    17.236, 52.219, 43.079, 43.079, 19.521, 17.236, 12.666, 21.806, 36.224, 21.806, 38.509, 38.509,
    21.806, 36.224, 36.224, 19.521, 12.666, 12.666, 52.219, 52.219, 17.236, 21.806, 17.236, 43.079,
    38.509, 43.079, 17.236, 17.236, 36.224, 19.521, 19.521, 38.509, 52.219, 38.509, 21.806, 12.666,
    38.509, 43.079, 21.806, 36.224, 19.521, 17.236, 36.224, 19.521, 52.219, 52.219, 52.219, 17.236,
    21.806, 36.224, 12.666, 21.806, 43.079, 2.431,  0.776,  4.436,  6.441,  34.219, 30.559, 0.776,
    28.554, 2.431,  2.431,  4.436,  32.564, 28.554, 30.559, 6.441,  4.436,  30.559, 28.554, 32.564,
    6.441,  34.219, 34.219, 32.564, 0.776,  4.436,  32.564, 2.431,  30.559, 34.219, 0.776,  28.554,
    4.436,  6.441,  34.219, 30.559, 2.431,  0.776,  6.441,  28.554};

// User Manuals of PandarXT-32 and XT-16: one channel after the other.
constexpr double kXtFirst_us = 6.0;

// Pandar64 User Manual, "Channel distribution": channels 7 to 54 look aside in turn.
double pandar64_azimuth_deg(std::size_t channel) {
  constexpr std::array<double, 6> kTurn_deg = {1.042, 3.125, 5.208, -5.208, -3.125, -1.042};
  const bool is_outer = channel < 6 || channel >= 54;
  return is_outer ? -1.042 : kTurn_deg[(channel - 6) % kTurn_deg.size()];
}

// The model of a packet that begins like this; nullptr: none that is read.
const HesaiModel* hesai_model_of(std::span<const std::byte> packet) {
  for (const HesaiModel& model : kModels) {
    if (packet.size() < model.packet_size()) continue;
    const bool is_it = packet[2] == std::byte{model.bytes_2_and_3[0]} &&
                       packet[3] == std::byte{model.bytes_2_and_3[1]};
    // Sensors of one protocol differ by their number of channels.
    const bool has_protocol = model.header_size == 12;
    const bool are_channels = !has_protocol || (packet[6] == std::byte(model.channels) &&
                                                packet[7] == std::byte(model.blocks));
    const bool has_parts = (packet[11] & std::byte{model.asked_parts}) == std::byte{model.parts};
    if (is_it && are_channels && has_parts) return &model;
  }
  return nullptr;
}

// When each channel fires, microseconds after its block's time; not in high resolution.
std::vector<double> hesai_firings_us(const HesaiModel& model) {
  if (model.channels == kPandar128Firing_us.size()) {
    return {kPandar128Firing_us.begin(), kPandar128Firing_us.end()};
  }
  std::vector<double> firings_us(model.channels);
  for (std::size_t i = 0; i < model.channels; ++i) {
    firings_us[i] = model.firing_step_us == 0.0
                        ? -kPandar64Lead_us[i]
                        : kXtFirst_us + model.firing_step_us * static_cast<double>(i);
  }
  return firings_us;
}

// Of a unit that was not measured.
std::vector<HesaiAngles> hesai_nominal_angles(const HesaiModel& model) {
  const Result<SensorProfile> profile = sensor_profile(model.profile);
  SIGHTLINE_CHECK(profile && profile->beam_elevations_deg.size() == model.channels);
  std::vector<HesaiAngles> angles(model.channels);
  for (std::size_t i = 0; i < model.channels; ++i) {  // the first channel looks highest
    angles[i] = {profile->beam_elevations_deg[model.channels - 1 - i],
                 model.firing_step_us == 0.0 ? pandar64_azimuth_deg(i) : 0.0};
  }
  return angles;
}

constexpr unsigned kTurn_cdeg = 36000;

int byte_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<int>(bytes[at]);
}

std::int64_t whole_ns(double us) { return std::llround(1e3 * us); }

// Return modes of the manuals: first, second, strongest, last; and two of them. 0: none of these.
std::size_t returns_of_mode(int mode) {
  if (mode == 0x33 || mode == 0x34 || mode == 0x37 || mode == 0x38) return 1;
  return (mode >= 0x39 && mode <= 0x3c) || mode == 0x3e ? 2 : 0;
}

class HesaiLidar : public RotatingLidar {
 public:
  HesaiLidar(const HesaiModel& model, std::vector<HesaiAngles> angles,
             std::vector<std::string> warnings)
      : model_(model),
        angles_(std::move(angles)),
        firings_us_(hesai_firings_us(model)),
        first_firing_us_(*std::ranges::min_element(firings_us_)),
        warnings_(std::move(warnings)) {}

  [[nodiscard]] std::string maker() const override { return "Hesai"; }
  [[nodiscard]] bool is_data(std::span<const std::byte> datagram) const override {
    return is_hesai_packet(datagram) && hesai_model_of(datagram) == &model_;
  }
  [[nodiscard]] std::size_t packet_size() const override { return model_.packet_size(); }

  [[nodiscard]] Result<void> check(std::span<const std::byte> bytes) const override {
    const int unit_mm = byte_at(bytes, model_.unit_at);
    const auto us = read_at<std::uint32_t>(bytes, model_.tail_begin() + model_.us_at);
    bool is_right = unit_mm >= 1 && unit_mm <= 20 && us < 2'000'000;
    for (std::size_t block = 0; block < model_.blocks; ++block) {
      is_right = is_right && azimuth_cdeg(bytes, block) < kTurn_cdeg;
    }
    if (!is_right) {
      return Error{ErrorCode::kMalformedHeader, concat("found a packet of a ", model_.name,
                                                       " with invalid azimuths, unit or time")};
    }
    if (returns(bytes) > 0) return {};
    return Error{ErrorCode::kUnsupportedFormat,
                 "found a return mode that is not read, expected one or two returns; export the "
                 "scans as PCD with PandarView"};
  }

  [[nodiscard]] int model(std::span<const std::byte> /*bytes*/) const override { return 0; }
  [[nodiscard]] std::size_t block_count() const override { return model_.blocks; }
  [[nodiscard]] unsigned azimuth_cdeg(std::span<const std::byte> bytes,
                                      std::size_t block) const override {
    return read_at<std::uint16_t>(bytes, block_at(block));
  }

  [[nodiscard]] std::int64_t time_ns(std::span<const std::byte> bytes) const override {
    const std::size_t date = model_.tail_begin() + model_.date_at;
    const auto part = [&](std::size_t i, int least, int most) {
      return std::clamp(byte_at(bytes, date + i), least, most);
    };
    // Firmwares count the years from 2000 or from 1900, which a year of this century shows.
    const int year = byte_at(bytes, date);
    const int first_year = year >= 100 ? 1900 : model_.first_year;
    // A clock that was not set may have no month and no day.
    const std::chrono::sys_days day(std::chrono::year(first_year + year) /
                                    std::chrono::month(static_cast<unsigned>(part(1, 1, 12))) /
                                    std::chrono::day(static_cast<unsigned>(part(2, 1, 31))));
    const std::int64_t seconds = std::int64_t{86'400} * day.time_since_epoch().count() +
                                 3600 * part(3, 0, 23) + 60 * part(4, 0, 59) + part(5, 0, 60);
    const auto us = read_at<std::uint32_t>(bytes, model_.tail_begin() + model_.us_at);
    return 1'000'000'000 * seconds + 1000 * std::int64_t{us};
  }

  [[nodiscard]] bool has_date() const override { return true; }
  [[nodiscard]] std::int64_t block_offset_ns(std::span<const std::byte> bytes,
                                             std::size_t block) const override {
    return whole_ns(block_us(bytes, block) + first_firing_us_);
  }

  void append_block(std::span<const std::byte> bytes, std::size_t block, std::int64_t base_ns,
                    PointCloudFile& cloud) const override {
    const double tick_m = 0.001 * byte_at(bytes, model_.unit_at);
    const double start_us = block_us(bytes, block);
    const double turn = turn_deg_per_us(bytes, block);
    const bool is_second = returns(bytes) == 2 && block % 2 == 1;
    for (std::size_t channel = 0; channel < model_.channels; ++channel) {
      const std::size_t at = block_at(block) + 2 + channel * model_.return_size;
      const auto ticks = read_at<std::uint16_t>(bytes, at);
      const bool is_repeated =
          is_second && ticks == read_at<std::uint16_t>(bytes, at - model_.block_size());
      if (ticks == 0 || is_repeated) {
        ++cloud.zero_count;
        continue;
      }
      const HesaiAngles& angles = angles_[channel];
      const double azimuth_deg =
          0.01 * azimuth_cdeg(bytes, block) + angles.azimuth_deg + turn * firing_us(bytes, channel);
      const Eigen::Vector3d direction =
          direction_of(kRadPerDeg * (90.0 - azimuth_deg), kRadPerDeg * angles.elevation_deg);
      if (add_point(cloud, tick_m * ticks * direction,
                    static_cast<float>(byte_at(bytes, at + 2)))) {
        cloud.time_offset_ns.push_back(
            static_cast<std::int32_t>(base_ns + whole_ns(start_us + firing_us(bytes, channel))));
      }
    }
  }

  [[nodiscard]] std::vector<std::byte> calibration() const override {
    ByteWriter bytes;
    for (const HesaiAngles& angles : angles_) {
      bytes.put(angles.elevation_deg);
      bytes.put(angles.azimuth_deg);
    }
    return bytes.take();
  }

  [[nodiscard]] std::vector<std::string> warnings() const override { return warnings_; }

 private:
  [[nodiscard]] std::size_t block_at(std::size_t block) const {
    return model_.header_size + block * model_.block_size();
  }
  [[nodiscard]] std::size_t returns(std::span<const std::byte> bytes) const {
    return returns_of_mode(byte_at(bytes, model_.tail_begin() + model_.mode_at));
  }
  [[nodiscard]] double block_us(std::span<const std::byte> bytes, std::size_t block) const {
    const std::size_t before_last =
        (model_.blocks - 1 - block) / std::max<std::size_t>(1, returns(bytes));
    return model_.last_block_us - step_us(bytes) * static_cast<double>(before_last);
  }
  [[nodiscard]] bool is_high_resolution(std::span<const std::byte> bytes) const {
    return model_.state_at > 0 && byte_at(bytes, model_.tail_begin() + model_.state_at) == 0;
  }
  // From a block to the next.
  [[nodiscard]] double step_us(std::span<const std::byte> bytes) const {
    return is_high_resolution(bytes) ? 0.5 * model_.block_us : model_.block_us;
  }
  // In high resolution each half of the firings is a block of its own.
  [[nodiscard]] double firing_us(std::span<const std::byte> bytes, std::size_t channel) const {
    const double us = firings_us_[channel];
    return is_high_resolution(bytes) && us > step_us(bytes) ? us - step_us(bytes) : us;
  }

  // How fast the head turns, as the packet says, or by the step to the next block: the last block
  // has none, it takes the step before.
  [[nodiscard]] double turn_deg_per_us(std::span<const std::byte> bytes, std::size_t block) const {
    if (model_.speed_at > 0) {
      constexpr double kDegPerUsOfRpm = 6e-6;
      constexpr int kMost_rpm = 20'000;  // far beyond any head
      const int rpm = read_at<std::uint16_t>(bytes, model_.tail_begin() + model_.speed_at);
      return rpm <= kMost_rpm ? kDegPerUsOfRpm * rpm : 0.0;
    }
    constexpr unsigned kMost_cdeg = 300;  // over 20 Hz, or packets that do not belong together
    const std::size_t stride = returns(bytes);
    const std::size_t from = block + stride < model_.blocks ? block : block - stride;
    const unsigned step_cdeg =
        (azimuth_cdeg(bytes, from + stride) + kTurn_cdeg - azimuth_cdeg(bytes, from)) % kTurn_cdeg;
    return step_cdeg <= kMost_cdeg ? 0.01 * step_cdeg / model_.block_us : 0.0;
  }

  const HesaiModel& model_;
  std::vector<HesaiAngles> angles_;
  std::vector<double> firings_us_;
  double first_firing_us_;
  std::vector<std::string> warnings_;
};

// The rows in the order of their channels.
Result<std::vector<HesaiAngles>> angles_of(const HesaiModel& model, std::string_view text,
                                           const std::string& file) {
  SIGHTLINE_ASSIGN(const std::vector<BeamRow> rows, parse_beam_table(text, file));
  const auto error = [&](const std::string& message) {
    return Error{ErrorCode::kBadValue, message, file};
  };
  if (rows.size() != model.channels) {
    return error(concat("found ", rows.size(), " channels, expected the ", model.channels, " of a ",
                        model.name));
  }
  std::vector<HesaiAngles> angles(model.channels);
  std::vector<bool> is_there(model.channels);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const BeamRow& row = rows[i];
    const auto channel = static_cast<std::size_t>(row.channel.value_or(static_cast<int>(i) + 1));
    if (channel < 1 || channel > model.channels || is_there[channel - 1]) {
      return error(
          concat("found channel ", channel, ", expected each of 1 to ", model.channels, " once"));
    }
    if (!row.azimuth_deg || std::abs(*row.azimuth_deg) > 360.0 ||
        std::abs(row.elevation_deg) > 90.0) {
      return error(concat("channel ", channel, ": expected an elevation and an azimuth"));
    }
    is_there[channel - 1] = true;
    angles[channel - 1] = {row.elevation_deg, *row.azimuth_deg};
  }
  return angles;
}

Error another_model(std::span<const std::byte> packet) {
  return {
      ErrorCode::kUnsupportedFormat,
      concat("found packets of another model of Hesai (", byte_at(packet, 2), ".",
             byte_at(packet, 3), ", ", packet.size(),
             " bytes), expected Pandar64, Pandar128 (1.4), PandarXT-32 or PandarXT-16; replay the "
             "capture to "
             "Hesai's ROS driver "
             "and record its points in a bag, or export the scans as PCD with PandarView")};
}

}  // namespace

bool is_hesai_packet(std::span<const std::byte> datagram) {
  constexpr std::size_t kShortest = 200;
  return datagram.size() >= kShortest && datagram[0] == std::byte{0xee} &&
         datagram[1] == std::byte{0xff};
}

Result<std::unique_ptr<const RotatingLidar>> hesai_lidar(std::span<const std::byte> first_packet,
                                                         const std::filesystem::path& correction) {
  const HesaiModel* model = hesai_model_of(first_packet);
  if (model == nullptr) return another_model(first_packet);
  if (model->needs_correction && correction.empty()) {
    return Error{ErrorCode::kMissingField,
                 concat("packets of a ", model->name,
                        " need the sensor's angle correction file. Save it from the sensor's web "
                        "page, and put it beside the capture with the same name and the ending "
                        ".csv, or name it as `sensor`")};
  }
  std::vector<HesaiAngles> angles = hesai_nominal_angles(*model);
  std::vector<std::string> warnings;
  if (correction.empty()) {
    warnings.push_back(concat(
        "the capture has no angle correction file beside it: the nominal angles of a ", model->name,
        " are used, which can be wrong by degrees. Save the sensor's file (CSV) from its web "
        "page"));
  } else {
    SIGHTLINE_ASSIGN(const std::string text, read_short_text(correction, kLargestHesaiCorrection));
    SIGHTLINE_ASSIGN(angles, angles_of(*model, text, correction.string()));
  }
  return std::unique_ptr<const RotatingLidar>(
      std::make_unique<HesaiLidar>(*model, std::move(angles), std::move(warnings)));
}

}  // namespace sightline
