#include "passes/trajectory/local/local_map.h"

#include <gtest/gtest.h>
#include <vector>

#include "passes/matching/match_score.h"
#include "tests/passes/matching/random_scene.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> room_100_m_off(std::uint64_t seed, std::size_t count) {
  std::vector<Eigen::Vector3d> points_m = room_points(seed, count, 0.02);
  for (Eigen::Vector3d& point_m : points_m) point_m.x() += 100.0;
  return points_m;
}

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

// A wall 5 m to the left of a sensor that moves along it.
std::vector<Eigen::Vector3d> wall_beside(double x_m) {
  std::vector<Eigen::Vector3d> points_m;
  for (int i = -30; i < 30; ++i) {
    for (int j = 0; j < 6; ++j) points_m.emplace_back(0.2 * i - 0.05 * x_m, 5.1, 0.3 * j - 0.9);
  }
  return points_m;
}

TEST(LocalMap, HasTheSameScansInDetail) {
  LocalMap read_often(10.0);
  LocalMap read_once(10.0);
  for (double x_m = 0.0; x_m < 30.0; x_m += 1.0) {
    Pose T_map_lidar = Pose::Identity();
    T_map_lidar.translation().x() = x_m;
    read_often.add(wall_beside(x_m), T_map_lidar, x_m);
    read_once.add(wall_beside(x_m), T_map_lidar, x_m);
    if (x_m > 3.0) {
      EXPECT_EQ(read_often.details().cell_m(), kDetailCell_m);
    }
  }
  std::size_t count = 0;
  for (std::int32_t x = 0; x < 80; ++x) {
    const CellKey key{x, 10, 0};
    const Nd* often = read_often.details().nd(key);
    const Nd* once = read_once.details().nd(key);
    ASSERT_EQ(often == nullptr, once == nullptr) << x;
    if (often == nullptr) continue;
    ++count;
    EXPECT_EQ(often->point_count, once->point_count);
    EXPECT_NEAR((often->mean_m - once->mean_m).norm(), 0.0, 1e-9);
  }
  EXPECT_GT(count, 20U);
}

TEST(RollingCells, AreLastingWherePointsCameAlongFiveMetres) {
  RollingCells cells(1.0);
  const std::vector<Eigen::Vector3d> wall_m = wall_beside(0.0);
  std::vector<Eigen::Vector3d> lorry_m;
  for (const Eigen::Vector3d& point_m : wall_m) {
    lorry_m.push_back(point_m - 8.0 * Eigen::Vector3d::UnitY());
  }
  for (double way_m = 0.0; way_m < 20.0; way_m += 1.0) {
    cells.add(gridded(wall_m).fine, 1.0, way_m);
    if (way_m > 7.0 && way_m < 12.0) cells.add(gridded(lorry_m).fine, 1.0, way_m);
  }
  cells.finish();
  EXPECT_TRUE(cells.is_lasting({0, 5, 0}));
  ASSERT_NE(cells.nd({0, -3, 0}), nullptr);
  EXPECT_FALSE(cells.is_lasting({0, -3, 0}));
  EXPECT_FALSE(cells.is_lasting({0, 0, 0}));
}

const Eigen::Matrix3d kLevel = Eigen::Matrix3d::Identity();

std::vector<Eigen::Vector3d> wall_and_ground() {
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 4; ++j) points_m.emplace_back(0.05 + 0.25 * i, 5.05, 0.3 + 0.5 * j);
    for (int j = 0; j < 8; ++j) points_m.emplace_back(0.05 + 0.25 * i, 0.05 + 0.5 * j, 0.0);
  }
  return points_m;
}

TEST(ScanOverlap, CountsWhatStandsAndNotTheGround) {
  const std::vector<Eigen::Vector3d> upright_m = upright_points(wall_and_ground(), kLevel);
  ASSERT_EQ(upright_m.size(), 160u);
  for (const Eigen::Vector3d& point_m : upright_m) EXPECT_EQ(point_m.y(), 5.05);
}

TEST(ScanOverlap, LevelsTheScanOfATiltedSensor) {
  const Eigen::Matrix3d tilt = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()).toRotationMatrix();
  std::vector<Eigen::Vector3d> tilted_m;
  for (const Eigen::Vector3d& point_m : wall_and_ground()) {
    tilted_m.push_back(tilt.transpose() * point_m);
  }
  EXPECT_LT(upright_points(tilted_m, kLevel).size(), 100u);  // the wall leans
  EXPECT_EQ(upright_points(tilted_m, tilt).size(), 160u);
}

// Half of a wall of 10 m moved along itself by 5 m meets it; moved off by 0.6 m nothing does.
TEST(ScanOverlap, IsTheShareThatMeetsTheMap) {
  const std::vector<Eigen::Vector3d> wall_m = upright_points(wall_and_ground(), kLevel);
  UprightMap map(50.0);
  EXPECT_FALSE(map.overlap(wall_m, Pose::Identity()).has_value());
  map.add(wall_m, Pose::Identity(), 0.0);
  EXPECT_EQ(*map.overlap(wall_m, Pose::Identity()), 1.0);
  EXPECT_NEAR(*map.overlap(wall_m, pose_at(5.0, 0.0, 0.0)), 0.5, 0.03);
  EXPECT_EQ(*map.overlap(wall_m, pose_at(0.0, 0.6, 0.0)), 0.0);
}

TEST(ScanOverlap, IsNoneForAHandfulOfReturns) {
  const std::vector<Eigen::Vector3d> wall_m = upright_points(wall_and_ground(), kLevel);
  UprightMap map(50.0);
  map.add(wall_m, Pose::Identity(), 0.0);
  const std::vector<Eigen::Vector3d> few_m(wall_m.begin(), wall_m.begin() + 29);
  EXPECT_FALSE(map.overlap(few_m, Pose::Identity()).has_value());
}

TEST(ScanOverlap, ForgetsWhatWasSeenTooLongAgo) {
  const std::vector<Eigen::Vector3d> wall_m = upright_points(wall_and_ground(), kLevel);
  UprightMap map(50.0);
  map.add(wall_m, Pose::Identity(), 0.0);
  map.add(wall_m, pose_at(49.0, 0.0, 0.0), 49.0);
  EXPECT_EQ(*map.overlap(wall_m, Pose::Identity()), 1.0);
  map.add(wall_m, pose_at(60.0, 0.0, 0.0), 60.0);
  EXPECT_EQ(*map.overlap(wall_m, Pose::Identity()), 0.0);
  EXPECT_EQ(map.points_m().size(), 2 * wall_m.size());
}

}  // namespace
}  // namespace sightline
