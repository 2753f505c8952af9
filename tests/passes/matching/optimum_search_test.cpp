#include "passes/matching/optimum_search.h"

#include <gtest/gtest.h>
#include <algorithm>

#include "passes/matching/localizer.h"
#include "passes/matching/match_starts.h"
#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/random_scene.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

TEST(SharedClimbs, TakesPosesForOneWithinACentimetreAndAMilliradian) {
  const Pose T_here = Pose::Identity();
  EXPECT_TRUE(SharedClimbs::are_one(T_here, T_here));
  EXPECT_TRUE(SharedClimbs::are_one(T_here, pose_at(0.009, 0.0, 0.0006)));
  EXPECT_FALSE(SharedClimbs::are_one(T_here, pose_at(0.011, 0.0, 0.0)));
  EXPECT_FALSE(SharedClimbs::are_one(T_here, pose_at(0.0, 0.0, 0.002)));
}

// What each of 24 starts finds, alone and where starts share.
struct Runs {
  std::vector<MatchResult> alone;
  std::vector<MatchResult> sharing;
  std::vector<double> taken_over_ms;
};

Runs runs_in(const NdtMap& map, const std::vector<Eigen::Vector3d>& points_m,
             double search_m = 1.25) {
  Localizer localizer = make_localizer(map, localizer_named("searching"));
  localizer.options.search_m = search_m;
  ScanForMatch scan = make_scan_for_match(localizer, points_m);
  Runs runs;
  SharedClimbs climbs;
  for (const InitialOffset& offset : initial_offsets({.count = 24})) {
    runs.alone.push_back(localize(localizer, scan, start_pose(offset)));
    runs.sharing.push_back(localize(localizer, scan, start_pose(offset), {}, &climbs));
    runs.taken_over_ms.push_back(climbs.taken_over_ms());
  }
  return runs;
}

// How many of them took over what an earlier one found: expects of each other that it found what it
// finds alone, to the bit.
int count_taken_over(const Runs& runs) {
  int taken_over = 0;
  for (std::size_t k = 0; k < runs.alone.size(); ++k) {
    if (runs.taken_over_ms[k] > 0.0) {
      ++taken_over;
      continue;
    }
    EXPECT_EQ(runs.sharing[k].T_map_sensor.matrix(), runs.alone[k].T_map_sensor.matrix());
    EXPECT_EQ(runs.sharing[k].score, runs.alone[k].score);
    EXPECT_EQ(runs.sharing[k].work, runs.alone[k].work);
    EXPECT_EQ(runs.sharing[k].iterations, runs.alone[k].iterations);
  }
  return taken_over;
}

// What all starts together took is what they take alone, but for where they ended a little apart.
void expect_counted_in_full(const Runs& runs) {
  double alone = 0.0;
  double sharing = 0.0;
  for (std::size_t k = 0; k < runs.alone.size(); ++k) {
    alone += static_cast<double>(runs.alone[k].work);
    sharing += static_cast<double>(runs.sharing[k].work);
  }
  EXPECT_NEAR(sharing, alone, 0.1 * alone);
}

TEST(SharedClimbs, InARoomMostStartsTakeOverAndEndWhereTheyEndAlone) {
  const Runs runs = runs_in(room_map(), voxel_subsample(room_points(22, 8000, 0.02), 1.0));
  EXPECT_GT(count_taken_over(runs), 4);
  for (std::size_t k = 0; k < runs.alone.size(); ++k) {
    const Eigen::Vector3d apart_m =
        runs.sharing[k].T_map_sensor.translation() - runs.alone[k].T_map_sensor.translation();
    EXPECT_LT(apart_m.norm(), 0.01) << "start " << k;
    // Nothing is loose in a room: who takes over ends where an earlier start did, to the bit.
    const auto is_same = [&](const MatchResult& result) {
      return result.T_map_sensor.matrix() == runs.sharing[k].T_map_sensor.matrix() &&
             result.score == runs.sharing[k].score;
    };
    const auto earlier = runs.sharing.begin() + static_cast<std::ptrdiff_t>(k);
    EXPECT_EQ(std::any_of(runs.sharing.begin(), earlier, is_same), runs.taken_over_ms[k] > 0.0)
        << "start " << k;
    EXPECT_GT(runs.sharing[k].work, 0U) << "what it stands for was work";
  }
  expect_counted_in_full(runs);
}

TEST(SharedClimbs, InALaneOfManyOptimaNoneIsTakenForAnother) {
  const Runs runs = runs_in(simple_map(lane_points(1, 30.0, 120000), 2.0),
                            voxel_subsample(lane_points(2, 12.0, 6000), 0.5));
  EXPECT_GT(count_taken_over(runs), 4);
  for (std::size_t k = 0; k < runs.alone.size(); ++k) {
    const Eigen::Vector3d apart_m =
        runs.sharing[k].T_map_sensor.translation() - runs.alone[k].T_map_sensor.translation();
    EXPECT_LT(apart_m.norm(), 0.05)
        << "start " << k << ": each decides from its own place which other optimum it tries";
  }
  expect_counted_in_full(runs);
}

// Which of two optima beside where many starts lead is near enough to be tried differs from start
// to start.
TEST(SharedClimbs, EachStartTriesTheOptimumWithinItsOwnReach) {
  const NdtMap map = simple_map(lane_points(1, 30.0, 120000), 2.0);
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(lane_points(2, 12.0, 6000), 0.5);
  for (const double search_m : {0.5, 0.8, 1.0}) {
    const Runs runs = runs_in(map, points_m, search_m);
    EXPECT_GT(count_taken_over(runs), 4);
    for (std::size_t k = 0; k < runs.alone.size(); ++k) {
      const double alone = static_cast<double>(runs.alone[k].work);
      EXPECT_NEAR(static_cast<double>(runs.sharing[k].work), alone, 0.2 * alone)
          << "start " << k << " within " << search_m << " m";
    }
  }
}

TEST(SharedClimbs, TheSameStartTakesOverAllThatItFoundAndWhatThatTook) {
  const Localizer localizer =
      make_localizer(simple_map(lane_points(1, 30.0, 120000), 2.0), localizer_named("searching"));
  ScanForMatch scan =
      make_scan_for_match(localizer, voxel_subsample(lane_points(2, 12.0, 6000), 0.5));
  for (const InitialOffset& offset : initial_offsets({.count = 24})) {
    SharedClimbs climbs;
    const MatchResult first = localize(localizer, scan, start_pose(offset), {}, &climbs);
    EXPECT_EQ(climbs.taken_over_ms(), 0.0);
    const MatchResult again = localize(localizer, scan, start_pose(offset), {}, &climbs);
    EXPECT_GT(climbs.taken_over_ms(), 0.0);
    EXPECT_EQ(again.T_map_sensor.matrix(), first.T_map_sensor.matrix());
    EXPECT_EQ(again.work, first.work);
    EXPECT_EQ(again.iterations, first.iterations);
    climbs.clear();
    EXPECT_EQ(climbs.taken_over_ms(), 0.0);
  }
}

}  // namespace
}  // namespace sightline
