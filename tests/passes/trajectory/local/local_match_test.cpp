#include "passes/trajectory/local/local_match.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/support/box_world.h"

namespace sightline {
namespace {

struct Place {
  LocalGrids grids;
  ThinnedScan scan;
  Pose T_map_lidar;
};

Place place_in(std::uint64_t seed) {
  constexpr std::size_t kMiddle = 6;
  std::vector<Pose> poses;
  for (int i = 0; i < 13; ++i) poses.push_back(pose_at(i, 0, 0));
  const TestDrive test = drive_through(random_street(seed), poses, 0.5);
  Place place;
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Pose T_map_lidar = test.truth.poses[k].T_map_vehicle * test.drive.sensor.T_vehicle_lidar;
    const Result<ThinnedScan> scan = read_thinned(test.drive, k);
    if (k == kMiddle) {
      place.scan = *scan;
      place.T_map_lidar = T_map_lidar;
      continue;
    }
    for (const Eigen::Vector3d& point_m : scan->to_map_m) points_m.push_back(T_map_lidar * point_m);
  }
  place.grids = local_grids(points_m);
  return place;
}

// Those that are left out ended where an earlier start did.
TEST(LocalSearch, FindsWhatEachStartFindsAlone) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Place place = place_in(seed);
    const std::vector<Pose> starts = starts_around(place.T_map_lidar, 3.0);
    LocalSearch search(place.grids, place.scan.to_match_m);
    std::vector<LocalMatch> found;
    for (const Pose& start : starts) {
      const std::optional<LocalMatch> match = search.match(start);
      if (match) found.push_back(*match);
      const LocalMatch alone = match_locally(place.grids, place.scan.to_match_m, start);
      const bool is_among = std::ranges::any_of(found, [&](const LocalMatch& one) {
        return (one.T_map_lidar.translation() - alone.T_map_lidar.translation()).norm() < 0.02 &&
               std::abs(one.likelihood - alone.likelihood) < 0.01;
      });
      EXPECT_TRUE(is_among) << "seed " << seed;
      if (match) {
        EXPECT_EQ(match->T_map_lidar.matrix(), alone.T_map_lidar.matrix());
        EXPECT_EQ(match->likelihood, alone.likelihood);
      }
    }
    EXPECT_FALSE(search.match(starts.front())) << "that was followed";
  }
}

TEST(LocalSearch, TheBestOfManyStartsIsThePlace) {
  const Place place = place_in(4);
  const Pose T_map_off = place.T_map_lidar * pose_at(1.5, -1.0, 0.0);
  const LocalMatch best = search_locally(place.grids, place.scan.to_match_m, T_map_off, 3.0);
  EXPECT_TRUE(best.is_good());
  EXPECT_LT((best.T_map_lidar.translation() - place.T_map_lidar.translation()).norm(), 0.1);
}

}  // namespace
}  // namespace sightline
