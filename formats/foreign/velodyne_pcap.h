#pragma once

#include <filesystem>
#include <memory>

#include "compiler/base/result.h"
#include "formats/foreign/scan_container.h"

namespace sightline {

// The whole revolutions of a Velodyne's pcap; errors of open_scan_container.
Result<std::shared_ptr<const ScanContainer>> open_velodyne_pcap(const std::filesystem::path& path);

}  // namespace sightline
