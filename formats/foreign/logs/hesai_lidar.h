#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "formats/base/result.h"
#include "formats/foreign/logs/rotating_pcap.h"

// Data packets of Hesai's Pandar64, Pandar128 (protocol 1.4), PandarXT-32 and PandarXT-16 as their
// User Manuals describe them: a header, blocks of an azimuth and the returns of all channels, a
// tail with mode and UTC time. Axes as Hesai's drivers have them: y along azimuth 0, x right, z up,
// from the sensor's origin. A channel looks a little beside the head's azimuth: its unit's angle
// correction file says how far.

namespace sightline {

// Whether a datagram begins as Hesai's data packets do.
bool is_hesai_packet(std::span<const std::byte> datagram);

inline constexpr std::size_t kLargestHesaiCorrection = std::size_t{1} << 20;  // bytes

// The reader of a sensor's packets by its first one. `correction`: the angle correction file of the
// unit (Channel,Elevation,Azimuth); empty: the model's nominal angles, with a warning. Errors:
// missing-field (of a Pandar128 without one),
// unsupported-format (another model; says how to convert it), malformed-text and bad-value (no
// such file, or one of another model), cannot-read.
Result<std::unique_ptr<const RotatingLidar>> hesai_lidar(std::span<const std::byte> first_packet,
                                                         const std::filesystem::path& correction);

}  // namespace sightline
