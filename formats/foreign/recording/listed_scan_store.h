#pragma once

#include <memory>

#include "formats/drive/drive.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// Reads the scans of a listed recording (list_recording), each file once and without digests: for
// who takes them in turn, as a vehicle does. Point times are offsets from the scan's stamp
// (settle_point_times). Keeps what it needs of the recording.
std::shared_ptr<const ScanStore> listed_scan_store(const Recording& recording);

}  // namespace sightline
