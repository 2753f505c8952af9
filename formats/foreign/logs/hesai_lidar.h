#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "formats/base/result.h"
#include "formats/foreign/logs/rotating_pcap.h"

// Data packets of Hesai's Pandar64, Pandar128 (protocol 1.4), PandarXT-32 and PandarXT-16 (User
// Manuals). Axes as Hesai's drivers have them: y along azimuth 0, x right, z up, from the sensor's
// origin. A channel's own azimuth is in its unit's angle correction file.

namespace sightline {

// Whether a datagram begins as Hesai's data packets do.
bool is_hesai_packet(std::span<const std::byte> datagram);

inline constexpr std::size_t kLargestHesaiCorrection = std::size_t{1} << 20;  // bytes

// The reader of a sensor's packets by its first one. `correction`: the unit's angle correction file
// (Channel,Elevation,Azimuth); empty: nominal angles, with a warning. Errors: missing-field (a
// Pandar128 without one), unsupported-format (another model), malformed-text and bad-value (no such
// file, or of another model), cannot-read.
Result<std::unique_ptr<const RotatingLidar>> hesai_lidar(std::span<const std::byte> first_packet,
                                                         const std::filesystem::path& correction);

}  // namespace sightline
