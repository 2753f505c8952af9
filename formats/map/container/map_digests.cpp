#include "formats/map/container/map_digests.h"

#include "formats/base/bytes.h"

namespace sightline {
namespace {

template <class... T>
void add_numbers(DigestBuilder& builder, T... values) {
  ByteWriter writer;
  (writer.put(values), ...);
  builder.add(writer.bytes());
}

void add_blocks(DigestBuilder& builder, const std::vector<BlockName>& blocks) {
  for (const BlockName& block : blocks) {
    builder.add(block.name);
    add_numbers(builder, block.version);
    add_numbers(builder, block.row_count);
    builder.add(block.raw_digest);
  }
}

}  // namespace

Digest tile_digest(TileKey key, const std::vector<BlockName>& required_layers) {
  DigestBuilder builder;
  builder.add("sightline tile");
  add_numbers(builder, key.x, key.y);
  add_blocks(builder, required_layers);
  return builder.finish();
}

Digest root_digest(const Digest& manifest, std::uint64_t incompatible_features,
                   const std::vector<Digest>& tiles,
                   const std::vector<BlockName>& required_sections) {
  DigestBuilder builder;
  builder.add("sightline map");
  builder.add(manifest);
  add_numbers(builder, incompatible_features);
  add_numbers(builder, std::uint64_t{tiles.size()});
  for (const Digest& tile : tiles) builder.add(tile);
  add_blocks(builder, required_sections);
  return builder.finish();
}

}  // namespace sightline
