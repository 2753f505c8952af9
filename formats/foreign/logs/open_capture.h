#pragma once

#include <filesystem>
#include <memory>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Opens a pcap by whose packets it holds, whole revolutions or frames: the first data packet of a
// maker decides. Velodyne VLP-16 and HDL-32E; Hesai Pandar64, Pandar128, PandarXT-32 and
// PandarXT-16, with angles of the correction file beside the capture, which a Pandar128 needs;
// Ouster, which needs its metadata beside the capture. `sensor`: the file that a recording names as
// its sensor (.json: Ouster's metadata, .csv: Hesai's correction), which goes before what lies
// beside the capture; empty: none. Errors: those of PcapReader and of the makers' readers;
// missing-field (no metadata of an Ouster), unsupported-format (packets of no LiDAR that is read;
// says how to convert them).
Result<std::shared_ptr<const ScanContainer>> open_capture(const std::filesystem::path& path,
                                                          const std::filesystem::path& sensor);

// The frames of an Ouster's pcap, whose metadata lies in `metadata`. Errors: those of
// parse_ouster_metadata, OusterPackets::of and
// PcapReader, mismatched-inputs, time-runs-backwards and drive-too-short, with the file they are
// of.
Result<std::shared_ptr<const ScanContainer>> open_ouster_pcap(
    const std::filesystem::path& path, const std::filesystem::path& metadata);

}  // namespace sightline
