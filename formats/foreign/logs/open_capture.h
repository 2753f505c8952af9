#pragma once

#include <filesystem>
#include <memory>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Opens a pcap by whose packets it holds: the first data packet of a maker decides.
//
// - Velodyne VLP-16 and HDL-32E: whole revolutions (rotating_pcap.h).
// - Hesai Pandar64, Pandar128, PandarXT-32 and PandarXT-16: whole revolutions; angles of the
//   correction file beside the capture (hesai_lidar.h), which a Pandar128 needs.
// - Ouster: whole frames; it needs the sensor's metadata beside the capture (ouster_pcap.h).
//
// `sensor`: the file that a recording names as its sensor (.json: Ouster's metadata, .csv: Hesai's
// angle correction); it goes before what lies beside the capture. Empty: none.
// Errors: those of PcapReader and of the makers' readers; missing-field (packets of an Ouster and
// no metadata), unsupported-format (packets of no LiDAR that is read; says how to convert them).
Result<std::shared_ptr<const ScanContainer>> open_capture(const std::filesystem::path& path,
                                                          const std::filesystem::path& sensor);

}  // namespace sightline
