#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <vector>

#include "formats/base/files/stored_bytes.h"
#include "formats/surroundings/tiled_nds.h"

namespace sightline {

// NDs that come in any order and are wanted tile by tile, in memory as far as they are few.
class NdsByTile {
 public:
  NdsByTile(double cell_m, double tile_m, std::size_t most_in_memory = kMostInMemory)
      : cell_m_(cell_m), tile_m_(tile_m), growing_(most_in_memory) {}

  // Those of a part of the map, of which each cell lies in one part alone; adds up its counts.
  // Safe from several threads. A failure is told by take().
  void add(const NdtMap& part);
  // All, once, after the last add(), in frame and with points as given. Errors: disk-full,
  // cannot-write, cannot-read.
  [[nodiscard]] Result<TiledNds> take(const MapFrame& frame, std::uint64_t point_count);

 private:
  static constexpr std::size_t kMostInMemory = TiledNdsWriter::kMostInMemory;
  struct Piece {
    std::uint64_t first = 0;  // among all NDs
    std::uint64_t count = 0;
  };

  double cell_m_;
  double tile_m_;
  std::uint64_t sparse_cell_count_ = 0;
  std::uint64_t degenerate_cell_count_ = 0;
  std::mutex mutex_;
  std::map<TileKey, std::vector<Piece>> pieces_;
  std::uint64_t count_ = 0;
  GrowingBytes growing_;
  Result<void> written_;
};

}  // namespace sightline
