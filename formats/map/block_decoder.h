#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "formats/map/compiled_map.h"
#include "formats/map/container/packed_block.h"

namespace sightline {

// Decodes raw layers and sections into a map, in any order. What to do about a fault is up to the
// caller: read_map() returns it, recover_map() leaves the block out.
class BlockDecoder {
 public:
  // Into a map whose manifest is decoded; it gets room for so many sites.
  BlockDecoder(std::size_t site_count, CompiledMap& map);

  // Call it before any factor is decoded: their sections state how many a site has.
  void expect_factors(const MapContainer& container);

  // Ignores what is unknown. Errors: bad-layer, bad-order.
  Result<void> decode_layer(const PackedBlock& block, std::span<const std::byte> raw, TileKey key);
  // Ignores what is unknown. Errors: bad-layer, invalid-artifact, digest-mismatch.
  Result<void> decode_section(const PackedBlock& block, std::span<const std::byte> raw);

  // Error: bad-layer where factors are named, but a site has none.
  [[nodiscard]] Result<void> check_factors() const;
  // Moves them into the map.
  void take_factors();

 private:
  struct ExpectedFactors {
    std::string_view names;  // of the section
    std::string_view layer;
    FactorTable table;
    std::vector<bool> is_filled;  // [site]
  };
  void expect(const MapContainer& container, std::string_view names, std::string_view layer,
              const std::vector<Look>& looks);

  CompiledMap& map_;
  std::vector<bool> is_filled_;  // [site]
  std::vector<ExpectedFactors> factors_;
};

}  // namespace sightline
