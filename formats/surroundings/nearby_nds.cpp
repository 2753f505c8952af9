#include "formats/surroundings/nearby_nds.h"

#include <algorithm>

namespace sightline {

NdtMap nds_over(const NdtMap& map, const Eigen::AlignedBox2d& box_m) {
  NdtMap near;
  near.frame = map.frame;
  near.cell_m = map.cell_m;
  near.tile_m = map.tile_m;
  if (box_m.isEmpty()) return near;
  const TileKey low = tile_key({box_m.min().x(), box_m.min().y(), 0.0}, map.tile_m);
  const TileKey high = tile_key({box_m.max().x(), box_m.max().y(), 0.0}, map.tile_m);
  const auto tile = [&](const Nd& nd) { return tile_of(nd.key, map.cell_m, map.tile_m); };
  auto nd = map.nds.begin();
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    nd = std::partition_point(nd, map.nds.end(), [&](const Nd& other) {
      return tile(other) < TileKey{x, low.y};
    });
    const auto end = std::partition_point(nd, map.nds.end(), [&](const Nd& other) {
      return tile(other) <= TileKey{x, high.y};
    });
    near.nds.insert(near.nds.end(), nd, end);
    nd = end;
  }
  return near;
}

}  // namespace sightline
