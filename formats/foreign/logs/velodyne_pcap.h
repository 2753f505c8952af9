#pragma once

#include <filesystem>
#include <memory>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// The whole revolutions of a Velodyne's pcap; errors of open_scan_container.
Result<std::shared_ptr<const ScanContainer>> open_velodyne_pcap(const std::filesystem::path& path);

}  // namespace sightline
