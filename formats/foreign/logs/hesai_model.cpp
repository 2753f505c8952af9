#include "formats/foreign/logs/hesai_model.h"

#include <array>

#include "formats/base/check.h"
#include "formats/drive/sensor_profile.h"

namespace sightline {
namespace {

constexpr std::array<HesaiModel, 3> kModels = {{
    {"Pandar64", "pandar64", {64, 6}, 8, 5, 64, 6, 3, 14, 16, 10, 22, 2000, -42.58, 55.56, 0.0},
    {"PandarXT-32", "xt32", {6, 1}, 12, 9, 32, 8, 4, 10, 13, 19, 24, 1900, 0.0, 50.0, 1.512},
    {"PandarXT-16", "xt16", {6, 1}, 12, 9, 16, 8, 4, 10, 13, 19, 24, 1900, 0.0, 50.0, 3.024},
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
    if (is_it && are_channels) return &model;
  }
  return nullptr;
}

std::vector<double> hesai_firings_us(const HesaiModel& model) {
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
