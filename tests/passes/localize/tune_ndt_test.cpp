#include "passes/localize/tune_ndt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "passes/localize/pcl/pcl_ndt.h"
#include "passes/matching/match_starts.h"
#include "tests/passes/localize/mapped_street.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

// Four combinations on three scans: two choose, one judges.
TuneNdtOptions few() {
  TuneNdtOptions options;
  options.filters = {{20.0, 2.0, 100}, {20.0, 2.0, 3000}, {60.0, 3.0, 100}, {}};
  options.reference = ErrorReference::kKnownPose;
  options.most_scans = 3;
  return options;
}

Result<NdtTuning> tuned(const TuneNdtOptions& options, const Trajectory& trajectory,
                        int threads = 1) {
  PassContext ctx;
  ctx.threads = threads;
  return tune_ndt(ctx, options, street().second.drive, trajectory, street().map, street().sites);
}

NdtTuning tuned(const TuneNdtOptions& options, int threads = 1) {
  return value_of(tuned(options, street().second.truth, threads));
}

std::vector<double> without_times(const NdtTuning& tuning) {
  std::vector<TriedFilters> all = tuning.tried;
  all.insert(all.end(), {tuning.defaults, tuning.cheapest, tuning.best});
  std::vector<double> figures;
  for (const TriedFilters& tried : all) {
    const NdtFigures& one = tried.figures;
    figures.insert(figures.end(), one.within_share.begin(), one.within_share.end());
    figures.insert(figures.end(), {one.lost_share, one.error_m, one.point_count, one.work});
  }
  return figures;
}

class TuneNdt : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_pcl_ndt()) GTEST_SKIP() << "built without PCL";
  }
};

TEST_F(TuneNdt, TriesAutowaresOwnNumbersOnce) {
  const std::vector<AutowareFilters> all = filters_to_try();
  EXPECT_EQ(std::ranges::count(all, AutowareFilters()), 1);
  EXPECT_EQ(all.size(), 75U);
}

// Of 18 scans numbers 3, 9 and 15 are taken; the second judges.
TEST_F(TuneNdt, MatchesTheJudgingScanFromEachTrackingStart) {
  const NdtTuning found = tuned(few());
  EXPECT_EQ(found.choosing_scan_count, 2U);
  ASSERT_EQ(found.judging_scan_count, 1U);
  EXPECT_EQ(found.start_count, 5U);
  const Drive& drive = street().second.drive;
  const Scan scan = value_of(drive.store->read(9));
  const Pose& T_map_vehicle = street().second.truth.poses[9].T_map_vehicle;
  PclNdt ndt(street().map, T_map_vehicle.translation());
  AutowareSampler sampler;
  const std::vector<Eigen::Vector3d> points_m =
      sampler.sample(scan, drive.sensor, AutowareFilters(), 1);
  ASSERT_LT(points_m.size(), 1500U) << "none is drawn at random";
  ndt.set_scan(points_m);
  double error_m = 0.0;
  for (const InitialOffset& start : tracking_offsets({})) {
    const PclMatch end = ndt.match(T_map_vehicle * start_pose(start));
    error_m += (end.T_map_scan.translation() - T_map_vehicle.translation()).norm() / 5.0;
  }
  EXPECT_NEAR(found.defaults.figures.error_m, error_m, 1e-12);
  EXPECT_EQ(found.defaults.figures.within_share[1], 1.0) << "exactly: it is a share of counts";
  EXPECT_EQ(found.defaults.figures.point_count, static_cast<double>(points_m.size()));
}

// By every other way to find them: sorted by work, and by share within the limit.
TEST_F(TuneNdt, ChoosesTheLeastWorkThatHoldsAsMuchAndTheMostThatIsHeld) {
  TuneNdtOptions options = few();
  options.limits_m = {0.02, 0.25};
  options.filters = {{15.0, 1.0, 50},  {15.0, 3.0, 50}, {60.0, 1.0, 30},
                     {60.0, 1.0, 600}, {60.0, 3.0, 30}, {}};
  const NdtTuning found = tuned(options);
  const double own = found.tried.back().figures.within_share[0];
  std::vector<TriedFilters> by_work = found.tried;
  std::ranges::stable_sort(by_work, {}, [](const TriedFilters& one) { return one.figures.work; });
  const auto holds_as_much = [&](const TriedFilters& one) {
    return one.figures.within_share[0] >= own - 1e-12 && one.figures.lost_share == 0.0;
  };
  EXPECT_LT(std::ranges::count_if(by_work, holds_as_much), 6) << "some do not";
  EXPECT_EQ(found.cheapest.filters, std::ranges::find_if(by_work, holds_as_much)->filters);
  const auto most = std::ranges::max_element(by_work, {}, [](const TriedFilters& one) {
    return std::lround(1e6 * one.figures.within_share[0]);  // of equals the first: the least work
  });
  EXPECT_EQ(found.best.filters, most->filters);
}

TEST_F(TuneNdt, IsTheSameForAnyNumberOfThreads) {
  EXPECT_EQ(without_times(tuned(few(), 1)), without_times(tuned(few(), 4)));
}

// Another count of points changes nothing where fewer are left.
TEST_F(TuneNdt, LeavesFiguresWhereTheFiltersLeaveTheSamePoints) {
  TuneNdtOptions options = few();
  options.filters = {{60.0, 3.0, 1000}, {}, {60.0, 3.0, 3000}};
  const NdtTuning found = tuned(options);
  for (const TriedFilters& tried : found.tried) {
    EXPECT_EQ(tried.figures.error_m, found.tried[0].figures.error_m);
    EXPECT_EQ(tried.figures.work, found.tried[0].figures.work);
  }
  options.filters = {{60.0, 3.0, 50}, {60.0, 3.0, 70}, {}};
  const NdtTuning few_points = tuned(options);
  EXPECT_EQ(few_points.tried[0].figures.point_count, 50.0);
  EXPECT_EQ(few_points.tried[1].figures.point_count, 70.0);
}

TEST_F(TuneNdt, MeasuresAgainstItsOwnMatchWherePosesAreNotKnown) {
  TuneNdtOptions options = few();
  Trajectory off = street().second.truth;
  for (TrajectoryPose& pose : off.poses) pose.T_map_vehicle.translation().y() += 0.3;
  EXPECT_GT(value_of(tuned(options, off)).defaults.figures.error_m, 0.2);
  options.reference = ErrorReference::kFullRangeMatch;
  EXPECT_LT(value_of(tuned(options, off)).defaults.figures.error_m, 0.1);
}

TEST_F(TuneNdt, RefusesADriveElsewhereAndAMapWithoutCells) {
  Trajectory elsewhere = street().second.truth;
  for (TrajectoryPose& pose : elsewhere.poses) pose.T_map_vehicle.translation().x() += 500.0;
  EXPECT_EQ(tuned(few(), elsewhere).error().code, ErrorCode::kNoOverlap);
  Trajectory shorter = street().second.truth;
  shorter.poses.pop_back();
  EXPECT_EQ(tuned(few(), shorter).error().code, ErrorCode::kMismatchedInputs);
  NdtMap empty = street().map;
  empty.nds.clear();
  EXPECT_EQ(tune_ndt({}, few(), street().second.drive, street().second.truth, empty, street().sites)
                .error()
                .code,
            ErrorCode::kEmptyMap);
}

NdtTuning judged(double within, double work) {
  NdtTuning tuning;
  tuning.limits_m = {0.1};
  tuning.defaults.figures = {{0.9}, 0.0, 0.05, 400.0, 2000.0, 8.0};
  tuning.cheapest.figures = tuning.best.figures = {{within}, 0.0, 0.05, 200.0, work, 4.0};
  return tuning;
}

TEST(NdtTuning, RecommendsWhatTheJudgingScansConfirm) {
  EXPECT_TRUE(judged(0.9, 1000.0).is_cheaper());
  EXPECT_TRUE(judged(0.89, 1800.0).is_cheaper()) << "a point less and a tenth less work";
  EXPECT_FALSE(judged(0.88, 1000.0).is_cheaper());
  EXPECT_FALSE(judged(0.9, 1900.0).is_cheaper());
  NdtTuning loses = judged(0.9, 1000.0);
  loses.cheapest.figures.lost_share = 0.01;
  EXPECT_FALSE(loses.is_cheaper());
  EXPECT_TRUE(judged(0.92, 4000.0).is_better());
  EXPECT_FALSE(judged(0.91, 4000.0).is_better()) << "one point more may be chance";
}

}  // namespace
}  // namespace sightline
