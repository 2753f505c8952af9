#include "formats/surroundings/nearby_nds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "formats/base/random.h"
#include "tests/support/toy_world.h"

namespace sightline {
namespace {

TEST(NearbyNds, HoldsAllOverTheBoxInTheirOrderAndNoneATileAway) {
  const NdtMap map = random_ndt_map(1, 3000, 400.0);
  Random random(2);
  std::size_t held = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector2d low_m(random.uniform(-450.0, 400.0), random.uniform(-450.0, 400.0));
    const Eigen::AlignedBox2d box_m(
        low_m, low_m + Eigen::Vector2d(random.uniform(0.0, 200.0), random.uniform(0.0, 200.0)));
    const NdtMap near = nds_over(map, box_m);
    EXPECT_TRUE(validate(near).has_value());
    EXPECT_EQ(near.cell_m, map.cell_m);
    auto next = near.nds.begin();
    for (const Nd& nd : map.nds) {
      const bool is_here = next != near.nds.end() && next->key == nd.key;
      if (is_here) ++next;
      const double off_m = box_m.exteriorDistance(nd.mean_m.head<2>().eval());
      EXPECT_TRUE(is_here || off_m > 0.0);
      EXPECT_TRUE(!is_here || off_m < 1.5 * map.tile_m);
    }
    EXPECT_EQ(next, near.nds.end()) << "each once, in the order of the map";
    held += near.nds.size();
  }
  EXPECT_GT(held, 100U);
  EXPECT_LT(held, 25 * map.nds.size());
}

TEST(NearbyNds, HoldsNothingOverAnEmptyBox) {
  EXPECT_TRUE(nds_over(random_ndt_map(1, 50, 30.0), Eigen::AlignedBox2d()).nds.empty());
}

}  // namespace
}  // namespace sightline
