#include "passes/map/tiles/nds_by_tile.h"

#include <algorithm>
#include <map>
#include <vector>

namespace sightline {

NdsByTile::NdsByTile(double cell_m, double tile_m, std::size_t most_in_memory)
    : head_{{}, cell_m, tile_m, {}, 0, 0, 0}, growing_(head_, most_in_memory) {}

void NdsByTile::add(const NdtMap& part) {
  const std::lock_guard<std::mutex> lock(mutex_);
  head_.sparse_cell_count += part.sparse_cell_count;
  head_.degenerate_cell_count += part.degenerate_cell_count;
  if (written_) written_ = growing_.append(part);
}

Result<TiledNds> NdsByTile::take(const MapFrame& frame, std::uint64_t point_count) {
  SIGHTLINE_TRY(written_);
  SIGHTLINE_ASSIGN(const TiledNds added, growing_.take());
  std::map<TileKey, std::vector<RowTile>> pieces;
  for (const RowTile& piece : added.tiles()) pieces[piece.key].push_back(piece);
  head_.frame = frame;
  head_.point_count = point_count;
  StoredTableWriter<NdtMap> writer(head_);
  for (const auto& [tile, of_tile] : pieces) {
    NdtMap nds = head_;
    for (const RowTile& piece : of_tile) {
      SIGHTLINE_ASSIGN(const NdtMap some, added.tile(piece));
      nds.nds.insert(nds.nds.end(), some.nds.begin(), some.nds.end());
    }
    std::ranges::sort(nds.nds, {}, &Nd::key);
    SIGHTLINE_TRY(writer.append(nds));
  }
  return writer.take();
}

}  // namespace sightline
