#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/map/block_decoder.h"
#include "formats/map/container/look_up_writer.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/map_summary.h"
#include "formats/reader/map_container.h"

namespace sightline {

// Whether NDs stay in memory once they have been checked: they are most of a map.
enum class KeepNds { kYes, kNo };

// Goes through a file block by block, in order, checks all of it and decodes on the way.
class MapDecoder {
 public:
  MapDecoder(const MapContainer& container, KeepNds keep_nds);

  // Once. Errors: those of read_map() that come after the container's.
  Result<CompiledMap> run();
  // What was found, ascending by name.
  [[nodiscard]] std::vector<MapSummary::Blocks> blocks() const;

 private:
  [[nodiscard]] Result<void> check_counts() const;
  void make_room();
  Result<RawBytes> raw_bytes(const PackedBlock& block);
  Result<void> decode_layer(const PackedBlock& block, std::span<const std::byte> raw, TileKey key);
  Result<void> visit_layer(const PackedBlock& block, TileKey key);
  Result<void> visit_tile(const schema::Tile& tile);
  Result<void> visit_column(const PackedBlock& block, std::span<const std::byte> raw);
  Result<void> visit_section(const PackedBlock& block);
  Result<void> visit_all();
  [[nodiscard]] Result<void> check_contents(const PackedTile& tile) const;
  [[nodiscard]] Result<void> check_look_up() const;
  [[nodiscard]] Result<void> check_end(const std::vector<Digest>& tiles) const;

  const MapContainer& container_;
  KeepNds keep_nds_;
  std::uint64_t checked_to_;  // every byte before it has been looked at
  CompiledMap map_;
  std::optional<BlockDecoder> decoder_;
  std::optional<LookUpBuilder> look_up_;
  BlockKinds required_kinds_;
  std::map<std::string, MapSummary::Blocks> blocks_;
};

}  // namespace sightline
