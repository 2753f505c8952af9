#include "formats/grid/cell_key.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "formats/base/random.h"

namespace sightline {
namespace {

TEST(FloorDivide, IsTheFloorOfTheQuotient) {
  EXPECT_EQ(floor_divide(7, 3), 2);
  EXPECT_EQ(floor_divide(-7, 3), -3);
  EXPECT_EQ(floor_divide(-6, 3), -2);
  EXPECT_EQ(floor_divide(-1, 32), -1);
  EXPECT_EQ(floor_divide(0, 5), 0);
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  EXPECT_EQ(floor_divide(kLeast, 1), kLeast);
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const auto value = static_cast<std::int32_t>(random.uniform(-1e6, 1e6));
    const auto divisor = static_cast<std::int32_t>(1 + random.below(100));
    ASSERT_EQ(floor_divide(value, divisor),
              static_cast<std::int32_t>(std::floor(static_cast<double>(value) / divisor)));
  }
}

TEST(CellKey, HasItsLowerFaceInside) {
  EXPECT_EQ(cell_key({2.0, -2.0, -2.1}, 2.0), (CellKey{1, -1, -2}));
  EXPECT_EQ(cell_key({1.9, -0.1, 0.0}, 2.0), (CellKey{0, -1, 0}));
  EXPECT_EQ(tile_key({64.0, -0.1, 99.0}, 64.0), (TileKey{1, -1}));
}

TEST(CellKey, IsThatOfItsCellsCentre) {
  Random random(2);
  for (const double cell_m : {0.1, 0.7, 2.0, 64.0}) {
    for (int i = 0; i < 1000; ++i) {
      const CellKey key{static_cast<std::int32_t>(random.uniform(-1e5, 1e5)),
                        static_cast<std::int32_t>(random.uniform(-1e5, 1e5)),
                        static_cast<std::int32_t>(random.uniform(-1e5, 1e5))};
      const Eigen::Vector3d centre_m = cell_centre_m(key, cell_m);
      ASSERT_EQ(cell_key(centre_m, cell_m), key);
      ASSERT_EQ(centre_m.x(), cell_centre_m(key.x, cell_m));
    }
  }
}

// Tables take the low bits, parts of a map the high ones.
TEST(HashOfACellKey, SpreadsNeighbouringCellsOverItsLowAndItsHighBits) {
  std::set<std::uint32_t> low;
  std::set<std::uint32_t> high;
  for (std::int32_t x = -16; x < 16; ++x) {
    for (std::int32_t y = -16; y < 16; ++y) {
      for (std::int32_t z = -2; z < 2; ++z) {
        low.insert(hash_of({x, y, z}) & 0xfff);
        high.insert(hash_of({x, y, z}) >> 20);
      }
    }
  }
  // 4096 keys into 4096 places at random fill 2589 of them.
  EXPECT_GT(low.size(), 2000U);
  EXPECT_GT(high.size(), 2000U);
}

}  // namespace
}  // namespace sightline
