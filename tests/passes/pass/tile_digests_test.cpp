#include "passes/pass/tile_digests.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

struct Thing {
  Eigen::Vector3d at_m;
  double value = 0.0;
};

std::vector<Thing> things(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<Thing> list;
  for (int i = 0; i < count; ++i) {
    list.push_back(
        {{random.uniform(-90.0, 90.0), random.uniform(-90.0, 90.0), 0.0}, random.uniform()});
  }
  return list;
}

TileDigests digests_of_things(const std::vector<Thing>& list) {
  TileDigests digests(10.0);
  for (const Thing& thing : list) {
    digests.add(thing.at_m, std::as_bytes(std::span(&thing.value, 1)));
  }
  digests.finish();
  return digests;
}

TEST(TileDigests, ChangeWithWhatLiesInTheTilesOfTheBoxAndWithNothingElse) {
  const std::vector<Thing> before = things(1, 300);
  const Eigen::AlignedBox2d box_m(Eigen::Vector2d(-23.0, 4.0), Eigen::Vector2d(17.0, 31.0));
  const Digest expected = digests_of_things(before).within(box_m);
  int inside = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    std::vector<Thing> after = before;
    after[i].value += 1.0;
    const TileKey tile = tile_key(after[i].at_m, 10.0);
    const bool is_inside = tile.x >= -3 && tile.x <= 1 && tile.y >= 0 && tile.y <= 3;
    inside += is_inside ? 1 : 0;
    EXPECT_EQ(digests_of_things(after).within(box_m) != expected, is_inside) << i;
  }
  EXPECT_GT(inside, 5);
  EXPECT_LT(inside, 100);
}

TEST(TileDigests, TellWhichTileAThingLiesIn) {
  const Eigen::AlignedBox2d box_m(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(29.0, 9.0));
  const auto one_at = [&](double x_m) {
    return digests_of_things({{{x_m, 5.0, 0.0}, 1.0}}).within(box_m);
  };
  EXPECT_EQ(one_at(5.0), one_at(6.0)) << "where in a tile is what the bytes say";
  EXPECT_NE(one_at(5.0), one_at(15.0));
  EXPECT_NE(one_at(5.0), digests_of_things({}).within(box_m));
}

TEST(TileDigests, AreOfTheBoxAroundAllPlaces) {
  const std::vector<Eigen::Vector3d> places_m = {{3.0, 4.0, 9.0}, {-1.0, 7.0, 0.0}};
  const Eigen::AlignedBox2d box_m = box_around(places_m, 2.0);
  EXPECT_EQ(box_m.min(), Eigen::Vector2d(-3.0, 2.0));
  EXPECT_EQ(box_m.max(), Eigen::Vector2d(5.0, 9.0));
}

}  // namespace
}  // namespace sightline
