#include "passes/vehicle/map_windows.h"

#include <gtest/gtest.h>

#include "tests/passes/vehicle/row_of_rooms.h"

namespace sightline {
namespace {

WindowOptions options_of_rooms() {
  return {.own = localizer_named("searching"), .usual_range_m = 20.0};
}

std::size_t held_count(const MapWindow& window) {
  return window.own.levels.back().grid->records.places.size();
}

TEST(MapWindows, HoldsWhatIsNearAndPreparesAheadOfTheVehicle) {
  const Result<MapTiles> tiles = MapTiles::open(written_row("searching"));
  ASSERT_TRUE(tiles);
  MapWindows windows(*tiles, options_of_rooms());
  const std::shared_ptr<const MapWindow> first = windows.at(room_place_m(0), 10.0);
  const std::size_t all_count =
      make_match_grid(row_of_rooms("searching", 1).ndt).records.places.size();
  EXPECT_GT(held_count(*first), 100u);
  EXPECT_LT(held_count(*first), all_count / 2);
  // What no kernel reads is freed.
  EXPECT_EQ(first->own.levels.back().grid->nds.capacity(), 0u);
  EXPECT_EQ(first->own.levels.back().grid->neighbourhoods.capacity(), 0u);
  EXPECT_EQ(windows.at(room_place_m(0), 10.0), first);
  // What is prepared ahead serves without being made by the match.
  for (double x_m = 0.0; x_m < 500.0; x_m += 2.0) {
    const Eigen::Vector3d p_m = room_place_m(0) + Eigen::Vector3d(x_m, 0.0, 0.0);
    while (!windows.prepare(p_m, 0.0)) {
    }
    const Eigen::Vector3d next_m = p_m + Eigen::Vector3d(10.0, 0.0, 0.0);
    const std::shared_ptr<const MapWindow> window = windows.at(next_m, 20.0);
    EXPECT_TRUE(serves(*window, {p_m.head<2>(), match_reach_m(options_of_rooms(), 20.0, 2.0)}));
    EXPECT_LT(held_count(*window), all_count / 2);
  }
}

TEST(MapWindows, AWindowThatReachesFartherIsMadeForALongerLook) {
  const Result<MapTiles> tiles = MapTiles::open(written_row("searching"));
  ASSERT_TRUE(tiles);
  MapWindows windows(*tiles, options_of_rooms());
  const std::shared_ptr<const MapWindow> near = windows.at(room_place_m(8), 10.0);
  const std::shared_ptr<const MapWindow> wide = windows.at(room_place_m(8), 200.0);
  EXPECT_NE(near, wide);
  EXPECT_GT(held_count(*wide), held_count(*near));
  const MapCircle circle{room_place_m(8).head<2>(), match_reach_m(options_of_rooms(), 200.0, 2.0)};
  EXPECT_TRUE(serves(*wide, circle));
  EXPECT_FALSE(serves(*near, circle));
}

TEST(MapWindows, WhereNothingIsMappedTheWindowIsEmpty) {
  const Result<MapTiles> tiles = MapTiles::open(written_row("searching"));
  ASSERT_TRUE(tiles);
  MapWindows windows(*tiles, options_of_rooms());
  const std::shared_ptr<const MapWindow> window = windows.at({-5000.0, 3e8, 0.0}, 50.0);
  EXPECT_EQ(held_count(*window), 1u);
  EXPECT_TRUE(windows.prepare({-5000.0, 3e8, 0.0}, 1e6));
}

}  // namespace
}  // namespace sightline
