#pragma once

#include <filesystem>
#include <memory>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// The frames of an Ouster's pcap, whose metadata lies in `metadata`. Errors: those of
// parse_ouster_metadata, OusterPackets::of and
// PcapReader, mismatched-inputs, time-runs-backwards and drive-too-short, with the file they are
// of.
Result<std::shared_ptr<const ScanContainer>> open_ouster_pcap(
    const std::filesystem::path& path, const std::filesystem::path& metadata);

}  // namespace sightline
