#include "passes/matching/optimum_search.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "passes/matching/localizer.h"
#include "passes/matching/match_starts.h"
#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

Pose moved_and_turned(double x_m, double yaw_rad) {
  Pose pose = Pose::Identity();
  pose.translation().x() = x_m;
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

TEST(SharedClimbs, FindsTheFirstThatEndedWithinACentimetre) {
  SharedClimbs climbs;
  EXPECT_EQ(climbs.find(Pose::Identity()), nullptr);
  for (const double x_m : {0.0, 0.006, 1.0}) {
    MatchResult found;
    found.score = x_m;
    climbs.add({moved_and_turned(x_m, 0.0), found});
  }
  ASSERT_NE(climbs.find(moved_and_turned(0.004, 0.0)), nullptr);
  EXPECT_EQ(climbs.find(moved_and_turned(0.004, 0.0))->found.score, 0.0) << "the first";
  ASSERT_NE(climbs.find(moved_and_turned(0.012, 0.0005)), nullptr);
  EXPECT_EQ(climbs.find(moved_and_turned(0.012, 0.0005))->found.score, 0.006);
  EXPECT_EQ(climbs.find(moved_and_turned(0.02, 0.0)), nullptr);
  EXPECT_EQ(climbs.find(moved_and_turned(0.004, 0.002)), nullptr) << "turned too far";
  climbs.clear();
  EXPECT_EQ(climbs.find(Pose::Identity()), nullptr);
}

// What each of 24 starts finds, alone and where starts share.
struct Runs {
  std::vector<MatchResult> alone;
  std::vector<MatchResult> sharing;
};

Runs runs_in(const NdtMap& map, const std::vector<Eigen::Vector3d>& points_m) {
  const Localizer localizer = make_localizer(map, localizer_named("searching"));
  ScanForMatch scan = make_scan_for_match(localizer, points_m);
  Runs runs;
  SharedClimbs climbs;
  for (const InitialOffset& offset : initial_offsets({.count = 24})) {
    runs.alone.push_back(localize(localizer, scan, start_pose(offset)));
    runs.sharing.push_back(localize(localizer, scan, start_pose(offset), {}, &climbs));
  }
  return runs;
}

// How many of them took over what an earlier one found: expects of each start that it found what it
// finds alone, to the bit, or what an earlier start found.
int count_taken_over(const Runs& runs) {
  int taken_over = 0;
  for (std::size_t k = 0; k < runs.alone.size(); ++k) {
    const auto is_same = [&](const MatchResult& result) {
      return result.T_map_sensor.matrix() == runs.sharing[k].T_map_sensor.matrix() &&
             result.score == runs.sharing[k].score;
    };
    if (is_same(runs.alone[k])) {
      EXPECT_EQ(runs.sharing[k].work, runs.alone[k].work);
      EXPECT_EQ(runs.sharing[k].iterations, runs.alone[k].iterations);
      continue;
    }
    ++taken_over;
    const auto earlier = runs.sharing.begin() + static_cast<std::ptrdiff_t>(k);
    EXPECT_TRUE(std::any_of(runs.sharing.begin(), earlier, is_same)) << "start " << k;
    EXPECT_GT(runs.sharing[k].work, 0U) << "what it stands for was work";
  }
  return taken_over;
}

TEST(SharedClimbs, InARoomMostStartsTakeOverAndEndWhereTheyEndAlone) {
  const Runs runs = runs_in(simple_map(room_points(21, 30000, 0.02), 1.0),
                            voxel_subsample(room_points(22, 8000, 0.02), 1.0));
  EXPECT_GT(count_taken_over(runs), 4);
  for (std::size_t k = 0; k < runs.alone.size(); ++k) {
    const Eigen::Vector3d apart_m =
        runs.sharing[k].T_map_sensor.translation() - runs.alone[k].T_map_sensor.translation();
    EXPECT_LT(apart_m.norm(), 0.01) << "start " << k;
  }
}

TEST(SharedClimbs, InALaneOfManyOptimaNoneIsTakenForAnother) {
  const Runs runs = runs_in(simple_map(lane_points(1, 30.0, 120000), 2.0),
                            voxel_subsample(lane_points(2, 12.0, 6000), 0.5));
  count_taken_over(runs);
  int differ = 0;
  for (std::size_t k = 0; k < runs.alone.size(); ++k) {
    const Eigen::Vector3d apart_m =
        runs.sharing[k].T_map_sensor.translation() - runs.alone[k].T_map_sensor.translation();
    differ += apart_m.norm() > 0.1 ? 1 : 0;
  }
  EXPECT_LE(differ, 1) << "where the search ends at its limit, starts may differ";
}

}  // namespace
}  // namespace sightline
