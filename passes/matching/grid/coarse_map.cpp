#include "passes/matching/grid/coarse_map.h"

#include <map>
#include <utility>

#include "formats/base/check.h"
#include "formats/surroundings/cell_moments.h"

namespace sightline {
NdtMap coarse_map(const NdtMap& map, int factor) {
  SIGHTLINE_CHECK(factor >= 1);
  NdtMap coarse = map;
  coarse.cell_m = factor * map.cell_m;
  while (!is_tiling(coarse.cell_m, coarse.tile_m)) coarse.tile_m += map.tile_m;
  std::map<std::pair<TileKey, CellKey>, CellMoments> cells;
  for (const Nd& nd : map.nds) {
    const CellKey key{floor_divide(nd.key.x, factor), floor_divide(nd.key.y, factor),
                      floor_divide(nd.key.z, factor)};
    cells[{tile_of(key, coarse.cell_m, coarse.tile_m), key}].add(
        nd, nd.mean_m - cell_centre_m(key, coarse.cell_m));
  }
  coarse.nds.clear();
  for (const auto& [place, moments] : cells) {
    coarse.nds.push_back(undecomposed_nd(place.second, moments, coarse.cell_m));
  }
  decompose(coarse.nds);
  return coarse;
}

}  // namespace sightline
