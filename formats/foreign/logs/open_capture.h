#pragma once

#include <filesystem>
#include <memory>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Opens a pcap by the maker of its first data packet, in whole revolutions or frames: Velodyne
// VLP-16 and HDL-32E; Hesai (hesai_lidar.h); Ouster. `sensor`: the file that a recording names as
// its sensor (.json: Ouster's metadata, .csv: Hesai's correction); empty: the one beside the
// capture. Errors: those of PcapReader and of the makers' readers; missing-field (no metadata of an
// Ouster), unsupported-format (packets of another LiDAR).
Result<std::shared_ptr<const ScanContainer>> open_capture(const std::filesystem::path& path,
                                                          const std::filesystem::path& sensor);

// The frames of an Ouster's pcap. Errors, with their file: those of parse_ouster_metadata,
// OusterPackets::of and PcapReader, mismatched-inputs, time-runs-backwards, drive-too-short.
Result<std::shared_ptr<const ScanContainer>> open_ouster_pcap(
    const std::filesystem::path& path, const std::filesystem::path& metadata);

}  // namespace sightline
