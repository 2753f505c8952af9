#include "passes/map/tiles/nds_by_tile.h"

#include <algorithm>

namespace sightline {

void NdsByTile::add(const NdtMap& part) {
  const std::vector<std::byte> bytes = encoded_nds(part.nds);
  const std::lock_guard<std::mutex> lock(mutex_);
  sparse_cell_count_ += part.sparse_cell_count;
  degenerate_cell_count_ += part.degenerate_cell_count;
  for (const Nd& nd : part.nds) {
    std::vector<Piece>& pieces = pieces_[tile_of(nd.key, cell_m_, tile_m_)];
    const bool goes_on = !pieces.empty() && pieces.back().first + pieces.back().count == count_;
    if (!goes_on) pieces.push_back({count_, 0});
    ++pieces.back().count;
    ++count_;
  }
  if (written_) written_ = growing_.append(bytes);
}

Result<TiledNds> NdsByTile::take(const MapFrame& frame, std::uint64_t point_count) {
  SIGHTLINE_TRY(written_);
  const StoredBytes bytes = growing_.take();
  const NdtMap head{frame,      cell_m_, tile_m_, {}, sparse_cell_count_, degenerate_cell_count_,
                    point_count};
  TiledNdsWriter writer;
  for (const auto& [tile, pieces] : pieces_) {
    NdtMap of_tile = head;
    for (const Piece& piece : pieces) {
      SIGHTLINE_ASSIGN(const std::vector<std::byte> encoded,
                       bytes.read(piece.first * kEncodedNd, piece.count * kEncodedNd));
      append_nds(encoded, of_tile);
    }
    std::ranges::sort(of_tile.nds, {}, &Nd::key);
    SIGHTLINE_TRY(writer.add(tile, of_tile.nds));
  }
  return writer.take(head);
}

}  // namespace sightline
