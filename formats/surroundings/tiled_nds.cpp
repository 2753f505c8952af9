#include "formats/surroundings/tiled_nds.h"

namespace sightline {

// A whole map has the bytes of its table.
void encode(const NdtMap& map, ByteWriter& writer) { encode_whole(map, writer); }
void decode(ByteReader& reader, NdtMap& map) { decode_whole(reader, map); }

NdtMap RowsOf<NdtMap>::head_of(const NdtMap& map) {
  NdtMap head = part_of(map, 0, 0);
  head.sparse_cell_count = map.sparse_cell_count;
  head.degenerate_cell_count = map.degenerate_cell_count;
  head.point_count = map.point_count;
  return head;
}

NdtMap RowsOf<NdtMap>::part_of(const NdtMap& head, std::size_t /*first*/, std::size_t /*count*/) {
  return {head.frame, head.cell_m, head.tile_m, {}, 0, 0, 0};
}

void RowsOf<NdtMap>::encode_head(const NdtMap& map, ByteWriter& writer) {
  sightline::encode(map.frame, writer);
  writer.put(map.cell_m);
  writer.put(map.tile_m);
  writer.put(map.sparse_cell_count);
  writer.put(map.degenerate_cell_count);
  writer.put(map.point_count);
}

void RowsOf<NdtMap>::decode_head(ByteReader& reader, NdtMap& map) {
  sightline::decode(reader, map.frame);
  reader.get(map.cell_m);
  reader.get(map.tile_m);
  reader.get(map.sparse_cell_count);
  reader.get(map.degenerate_cell_count);
  reader.get(map.point_count);
}

void RowsOf<NdtMap>::encode(const NdtMap& map, std::size_t first, std::size_t count,
                            ByteWriter& writer) {
  for (const Nd& nd : std::span(map.nds).subspan(first, count)) {
    writer.put(nd.key.x);
    writer.put(nd.key.y);
    writer.put(nd.key.z);
    writer.put(nd.point_count);
    for (int i = 0; i < 3; ++i) writer.put(nd.mean_m[i]);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) writer.put(nd.covariance_m2(i, j));
    }
  }
}

void RowsOf<NdtMap>::decode(ByteReader& reader, NdtMap& map, std::size_t first, std::size_t count) {
  const std::span<Nd> nds = std::span(map.nds).subspan(first, count);
  for (Nd& nd : nds) {
    reader.get(nd.key.x);
    reader.get(nd.key.y);
    reader.get(nd.key.z);
    reader.get(nd.point_count);
    for (int i = 0; i < 3; ++i) reader.get(nd.mean_m[i]);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        reader.get(nd.covariance_m2(i, j));
        nd.covariance_m2(j, i) = nd.covariance_m2(i, j);
      }
    }
  }
  // Not stored: they follow from the covariance, to the bit.
  decompose(nds);
}

TileKey RowsOf<NdtMap>::tile(const NdtMap& head, std::span<const std::byte> row) {
  ByteReader reader(row);
  CellKey key;
  reader.get(key.x);
  reader.get(key.y);
  reader.get(key.z);
  return tile_of(key, head.cell_m, head.tile_m);
}

}  // namespace sightline
