#include "passes/trajectory/local/local_map.h"

#include <gtest/gtest.h>

#include <vector>

#include "passes/matching/match_score.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> room_100_m_off(std::uint64_t seed, std::size_t count) {
  std::vector<Eigen::Vector3d> points_m = room_points(seed, count, 0.02);
  for (Eigen::Vector3d& point_m : points_m) point_m.x() += 100.0;
  return points_m;
}

// One wall of it, or all.
std::vector<Eigen::Vector3d> some_of_room(std::uint64_t seed, bool is_all) {
  std::vector<Eigen::Vector3d> points_m = room_points(seed, 16000, 0.02);
  std::erase_if(points_m,
                [&](const Eigen::Vector3d& point_m) { return !is_all && point_m.x() > -9.0; });
  return points_m;
}

void expect_same_scores(const LocalGrids& found, const LocalGrids& expected,
                        const std::vector<Eigen::Vector3d>& points_m) {
  const Pose pose(Eigen::Translation3d(0.1, -0.2, 0.05));
  const auto expect_same = [&](const MatchGrid& grid, const MatchGrid& other) {
    const MatchScore score = match_score(grid, points_m, pose);
    const MatchScore expected_score = match_score(other, points_m, pose);
    EXPECT_EQ(score.score, expected_score.score);
    EXPECT_EQ(score.scored_points, expected_score.scored_points);
    EXPECT_EQ(score.hessian, expected_score.hessian);
  };
  expect_same(found.coarse(), expected.coarse());
  expect_same(found.fine(), expected.fine());
  expect_same(found.sharp(), expected.sharp());
}

// Where few cells were left they wait, where many were they are forgotten.
TEST(LocalGrids, KnowNothingOfPointsThatWent) {
  for (const bool leaves_most : {false, true}) {
    const GriddedPoints stays = gridded(room_100_m_off(1, leaves_most ? 500 : 8000));
    // Of two scans, whose sums leave rounding behind.
    const GriddedPoints goes = gridded(some_of_room(2, leaves_most));
    const GriddedPoints goes_too = gridded(some_of_room(6, leaves_most));
    const GriddedPoints comes = gridded(some_of_room(3, leaves_most));
    std::vector<Eigen::Vector3d> asked_m = room_points(4, 1000, 0.05);
    for (const Eigen::Vector3d& point_m : room_100_m_off(5, 1000)) asked_m.push_back(point_m);
    LocalGrids grids, never_had;
    grids.add(stays, 1.0);
    grids.add(goes, 1.0);
    grids.add(goes_too, 1.0);
    grids.finish();
    grids.add(goes, -1.0);
    grids.add(goes_too, -1.0);
    grids.finish();
    never_had.add(stays, 1.0);
    never_had.finish();
    expect_same_scores(grids, never_had, asked_m);
    grids.add(comes, 1.0);
    grids.finish();
    never_had.add(comes, 1.0);
    never_had.finish();
    expect_same_scores(grids, never_had, asked_m);
    EXPECT_GT(match_score(grids.fine(), asked_m, Pose::Identity()).scored_points, 500u);
  }
}

}  // namespace
}  // namespace sightline
