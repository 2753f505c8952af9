#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/drive/drive.h"

namespace sightline {

// Where a scan of a joined drive comes from.
struct ScanOrigin {
  bool is_other = false;
  std::size_t index = 0;
  std::int64_t moved_ns = 0;  // added to the scan's time
};

// Scans of two stores in the order of `origins`; read from where they are.
std::shared_ptr<const ScanStore> joined_scan_store(std::shared_ptr<const ScanStore> first,
                                                   std::shared_ptr<const ScanStore> other,
                                                   std::vector<ScanOrigin> origins);

}  // namespace sightline
