#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/drive/drive.h"

namespace sightline {

// Scans that were read, up to a bound of memory, shared by the drives of one run. Passes that work
// tile by tile ask for a scan once for each tile that it reaches, which costs most where scans are
// compressed or lie far away. Which scan makes room for another is a matter of chance, from a fixed
// seed: a caller that reads all scans in turn, again and again, would else never find one.
class ScanMemory {
 public:
  // What a compile may keep: the scans of a kilometre of 16 beams, so that passes which come back
  // to it, one after another and tile by tile, seldom read one again. A tile of 128 m is reached by
  // the scans of 330 m: so many of 32 beams, or half of them of 64.
  static constexpr std::size_t kMost_bytes = std::size_t{256} << 20;
  static constexpr std::size_t kMost_scans = 1200;

  // A scan takes 12 bytes a point, 24 where its coordinates are no floats, and 4 more with times.
  ScanMemory(std::size_t most_bytes, std::size_t most_scans);
  ~ScanMemory();
  ScanMemory(const ScanMemory&) = delete;
  ScanMemory& operator=(const ScanMemory&) = delete;

  // The store with this memory before it: gives the same scans, bit by bit, for as long as both are
  // alive. A scan that could not be read is asked for again.
  static std::shared_ptr<const ScanStore> before(std::shared_ptr<const ScanStore> store,
                                                 std::shared_ptr<ScanMemory> memory);

  [[nodiscard]] std::size_t bytes() const;  // that are in use

 private:
  class Store;
  struct Kept;
  std::unique_ptr<Kept> kept_;
};

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
