#include "passes/pass/tile_digests.h"

namespace sightline {
namespace {

// A quarter of what most looks reach: a finer grid would only be dearer to ask.
constexpr double kTile_m = 16.0;

}  // namespace

void TileDigests::add(const Eigen::Vector3d& at_m, std::span<const std::byte> bytes) {
  growing_[tile_key(at_m, tile_m_)].add(bytes);
}

void TileDigests::finish() {
  for (auto& [tile, builder] : growing_) of_tile_[tile] = builder.finish();
  growing_.clear();
}

Digest TileDigests::within(const Eigen::AlignedBox2d& box_m) const {
  const auto tile_at = [&](const Eigen::Vector2d& corner_m) {
    return tile_key({corner_m.x(), corner_m.y(), 0.0}, tile_m_);
  };
  const TileKey low = tile_at(box_m.min());
  const TileKey high = tile_at(box_m.max());
  DigestBuilder builder;
  auto tile = of_tile_.lower_bound(low);
  while (tile != of_tile_.end() && tile->first.x <= high.x) {
    if (tile->first.y < low.y) {
      tile = of_tile_.lower_bound({tile->first.x, low.y});
    } else if (tile->first.y > high.y) {
      tile = of_tile_.lower_bound({tile->first.x + 1, low.y});
    } else {
      builder.add(written(tile->first).bytes());
      builder.add(tile->second);
      ++tile;
    }
  }
  return builder.finish();
}

Result<TileDigests> digests_of(const TiledNds& nds) {
  TileDigests digests(kTile_m);
  for (const RowTile& tile : nds.tiles()) {
    SIGHTLINE_ASSIGN(const NdtMap of_tile, nds.tile(tile));
    for (const Nd& nd : of_tile.nds) {
      digests.add(nd.mean_m, written(nds.head().cell_m, nds.head().tile_m, nd.key, nd.point_count,
                                     nd.mean_m, nd.covariance_m2)
                                 .bytes());
    }
  }
  digests.finish();
  return digests;
}

Result<TileDigests> digests_of(const TiledSurface& surface) {
  TileDigests digests(kTile_m);
  for (const RowTile& tile : surface.tiles()) {
    SIGHTLINE_ASSIGN(const Surface of_tile, surface.tile(tile));
    for (const SurfacePatch& patch : of_tile.patches) {
      digests.add(patch.centre_m, written(surface.head().cell_m, patch).bytes());
    }
  }
  digests.finish();
  return digests;
}

void put_place(const Site& site, ByteWriter& writer) {
  encode(site.T_map_vehicle, writer);
  FieldWriter(writer).put(site.p_map_m);
}

Eigen::AlignedBox2d box_around(std::span<const Eigen::Vector3d> places_m, double reach_m) {
  Eigen::AlignedBox2d box_m;
  for (const Eigen::Vector3d& place_m : places_m) box_m.extend(place_m.head<2>());
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(reach_m);
  return {box_m.min() - reach, box_m.max() + reach};
}

}  // namespace sightline
