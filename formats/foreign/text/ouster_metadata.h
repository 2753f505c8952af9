#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// What an Ouster sensor says of itself in its metadata (.json), of all versions of its firmware:
// what lies in a member of its own there counts one level deeper too.
struct OusterMetadata {
  std::vector<double> altitudes_deg;  // of the beams, in the order of pixels; at least one
  std::vector<double> azimuths_deg;   // beside the encoder's; as many, or none
  std::size_t columns_per_frame = 0;  // 0: it does not say
  std::size_t columns_per_packet = 16;
  std::size_t first_column = 0;  // of the window that is sent, both included; the last may be
  std::size_t last_column = 0;   // the smaller number
  std::string profile = "LEGACY";
  // Of the beams' origin on the turning head: from the axis, and above the lidar frame's origin.
  std::optional<double> beam_radius_mm;
  double beam_height_mm = 0.0;
  std::optional<Eigen::Matrix4d> lidar_to_sensor;  // its translation in mm
  std::string product;                             // "OS-1-128"; empty: it does not say
};

inline constexpr std::size_t kLargestOusterMetadata = std::size_t{1} << 20;  // bytes

// Errors: malformed-text (no such metadata, or a value of another type), bad-value (a count or an
// angle that no sensor has).
Result<OusterMetadata> parse_ouster_metadata(std::string_view text,
                                             const std::filesystem::path& path);

}  // namespace sightline
