#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

// How the packets of Hesai's models are laid out and their lasers fire; User Manuals, chapter "Data
// structure" and appendices "Absolute time" and "Channel distribution".

namespace sightline {

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

// The model of a packet that begins like this; nullptr: none that is read.
const HesaiModel* hesai_model_of(std::span<const std::byte> packet);

// When each channel fires, microseconds after its block's time; not in high resolution.
std::vector<double> hesai_firings_us(const HesaiModel& model);

// Of a unit that was not measured.
std::vector<HesaiAngles> hesai_nominal_angles(const HesaiModel& model);

}  // namespace sightline
