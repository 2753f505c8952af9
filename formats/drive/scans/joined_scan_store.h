#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/drive/drive.h"

namespace sightline {

// Where a scan of a joined drive comes from.
struct ScanOrigin {
  std::size_t store = 0;
  std::size_t index = 0;      // in that store
  std::int64_t moved_ns = 0;  // added to the scan's time
};

// Scans of several stores in the order of `origins`; read from where they are.
std::shared_ptr<const ScanStore> joined_scan_store(
    std::vector<std::shared_ptr<const ScanStore>> stores, std::vector<ScanOrigin> origins);

}  // namespace sightline
