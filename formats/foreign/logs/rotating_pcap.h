#pragma once

#include <filesystem>
#include <memory>

#include "formats/base/result.h"
#include "formats/foreign/logs/rotating_lidar.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// The whole revolutions of a turning LiDAR in a pcap. Errors: those of find_revolutions.
Result<std::shared_ptr<const ScanContainer>> open_rotating_pcap(
    const std::filesystem::path& path, std::unique_ptr<const RotatingLidar> lidar);

// Of Velodyne's VLP-16 and HDL-32E (velodyne_packet.h); errors of open_scan_container.
Result<std::shared_ptr<const ScanContainer>> open_velodyne_pcap(const std::filesystem::path& path);

}  // namespace sightline
