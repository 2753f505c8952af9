#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "compiler/base/result.h"
#include "formats/reader/map_container.h"

// The nearest site as a map without a section "look-up" tells it (format 1.0): from the range
// layers of the tiles around a place.

namespace sightline {

// The nearest site so far, and where it is stored.
struct StoredSite {
  double distance2_m2 = 0.0;
  std::uint32_t site = 0;
  std::uint64_t row = 0;
  std::uint64_t row_count = 0;
  const std::byte* layer = nullptr;  // none within reach
};

// Safe to use from several threads at once. A search allocates nothing but to tell of a failure,
// and checks a tile against its checksum before its first use.
class TileSearch {
 public:
  explicit TileSearch(const MapContainer& container);

  // The site nearest to a place in map coordinates, at most the map's reach away.
  // Error: checksum-mismatch.
  [[nodiscard]] Result<StoredSite> nearest(const std::array<double, 3>& p_m) const;

 private:
  Result<void> search(std::int32_t x, std::int32_t y, const std::array<double, 3>& p_m,
                      StoredSite& nearest) const;
  Result<const std::byte*> checked_tile(std::uint32_t tile, const schema::Block& layer) const;

  MapContainer container_;
  double tile_m_ = 0.0;
  double reach_m_ = 0.0;
  std::size_t range_count_ = 0;
  std::size_t limit_count_ = 0;
  // Per tile: whether its range layer has been checked. Two threads may both check it.
  std::unique_ptr<std::atomic<std::uint8_t>[]> tile_states_;
};

}  // namespace sightline
