#pragma once

#include <cstdint>
#include <mutex>

#include "formats/surroundings/ndt_map.h"
#include "formats/tables/stored_table_writer.h"

namespace sightline {

// NDs that come in any order and are wanted tile by tile, in memory as far as they are few.
class NdsByTile {
 public:
  NdsByTile(double cell_m, double tile_m,
            std::size_t most_in_memory = StoredTableWriter<NdtMap>::kMostInMemory);

  // Those of a part of the map, of which each cell lies in one part alone; adds up its counts.
  // Safe from several threads. take() returns its errors.
  void add(const NdtMap& part);
  // All, once, after the last add(), in frame and with points as given. Errors: disk-full,
  // cannot-write, cannot-read.
  [[nodiscard]] Result<TiledNds> take(const MapFrame& frame, std::uint64_t point_count);

 private:
  NdtMap head_;
  std::mutex mutex_;
  StoredTableWriter<NdtMap> growing_;  // in the order of add(): a tile may come several times
  Result<void> written_;
};

}  // namespace sightline
