#include "formats/foreign/logs/hesai_model.h"

#include <array>

#include "formats/base/check.h"
#include "formats/drive/sensor_profile.h"

namespace sightline {
namespace {

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

}  // namespace

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

}  // namespace sightline
