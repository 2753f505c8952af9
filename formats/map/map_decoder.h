#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/map/compiled_map.h"
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
  // Factors whose names were found, on the way.
  struct ExpectedFactors {
    std::string_view names;  // of the section
    std::string_view layer;
    FactorTable table;
    std::vector<bool> is_filled;  // [site]
  };
  [[nodiscard]] Result<void> check_padding(std::uint64_t begin, std::uint64_t end) const;
  [[nodiscard]] Result<void> check_counts() const;
  void make_room();
  void expect_factors(std::string_view names, std::string_view layer,
                      const std::vector<Look>& looks);
  void take_factors();
  Result<RawBytes> raw_bytes(const PackedBlock& block);
  Result<void> decode_nds(std::span<const std::byte> raw, std::uint64_t row_count, TileKey key);
  Result<void> visit_layer(const PackedBlock& block, TileKey key);
  Result<void> visit_tile(const schema::Tile& tile);
  Result<void> visit_section(const PackedBlock& block);
  Result<void> visit_all();
  [[nodiscard]] Result<void> check_contents(TileKey key, const Digest& digest,
                                            const std::vector<PackedBlock>& layers) const;
  [[nodiscard]] Result<void> check_look_up() const;
  [[nodiscard]] Result<void> check_factors() const;
  [[nodiscard]] Result<void> check_end(const std::vector<Digest>& tiles) const;

  const MapContainer& container_;
  KeepNds keep_nds_;
  std::uint64_t checked_to_;  // every byte before it has been looked at
  CompiledMap map_;
  std::vector<bool> is_filled_;
  std::vector<ExpectedFactors> factors_;
  std::optional<LookUpBuilder> look_up_;
  BlockKinds required_kinds_;
  std::map<std::string, MapSummary::Blocks> blocks_;
};

}  // namespace sightline
