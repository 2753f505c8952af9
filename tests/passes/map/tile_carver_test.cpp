#include "passes/map/tile_carver.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <vector>

#include "tests/passes/map/tiles/long_street.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

SeenVoxels seen_by(const CarveOptions& options, const SurfacePoints& points, const TileKey& tile) {
  const std::vector<PlacedScan> scans =
      scans_of_tile(options, points.scans, origins_of(points.scans), tile);
  return value_of(look_at_tile(options, *points.store, scans, tile));
}

struct Agreement {
  int voxels = 0;
  std::uint32_t misses = 0;
};

// Near the border of a tile and the next one along x, which both have all that says what is ground.
void expect_the_same(const CarveOptions& options, const SurfacePoints& points, const TileKey& tile,
                     Agreement& agreement) {
  const SeenVoxels left = seen_by(options, points, tile);
  const SeenVoxels right = seen_by(options, points, {tile.x + 1, tile.y});
  const Eigen::Vector2d border_m = options.tile_m * Eigen::Vector2d(tile.x + 1, tile.y + 0.5);
  for (std::size_t v = 0; v < left.size(); ++v) {
    const CellKey& key = left.keys()[v];
    const Eigen::Vector2d from_m =
        (cell_centre_m(key, options.voxel_m).head<2>() - border_m).cwiseAbs();
    if (from_m.x() > 4.0 * options.voxel_m || from_m.y() > 0.5 * options.tile_m) continue;
    const SeenVoxel* other = right.find(key);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(left.values()[v].hits, other->hits);
    EXPECT_EQ(left.values()[v].misses, other->misses) << key.x << " " << key.y << " " << key.z;
    agreement.misses += other->misses;
    ++agreement.voxels;
  }
}

// Each tile takes only the rays that come over it: those that look through a voxel must be among
// them whichever tile asks.
TEST(TileCarver, TwoTilesSayTheSameOfVoxelsBetweenThem) {
  const SurfacePoints points = long_street(5);
  const CarveOptions options{0.5, 60.0, 32.0};
  Agreement agreement;
  for (const std::int32_t y : {3, 4}) {
    for (std::int32_t x = -4; x < 4; ++x) expect_the_same(options, points, {x, y}, agreement);
  }
  EXPECT_GT(agreement.voxels, 1000);
  EXPECT_GT(agreement.misses, 30U);
}

}  // namespace
}  // namespace sightline
