#include "passes/matching/localizer.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

#include "examples/town/drive/drive.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/allocation_counter.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

const LocalizerOptions kVariants[] = {{.is_annealed = false, .coarse_cells = 1},
                                      {.is_annealed = false, .coarse_cells = 2},
                                      {.is_annealed = true, .coarse_cells = 1},
                                      {.is_annealed = true, .coarse_cells = 2},
                                      {.is_annealed = true, .search_m = 1.25}};

// A minute's street without noise: a map of one drive, scans of another beside it.
struct Street {
  NdtMap map;
  std::vector<std::vector<Eigen::Vector3d>> scans;
  std::vector<Pose> T_map_scan;
};

Street make_street() {
  const town::Town town = *town::make_town({.seed = 3, .length_m = 60.0});
  town::DriveOptions options = town::usual_drive(town.options, 0, *town::town_sensor(16));
  options.range_sigma_m = 0.0;
  Street street;
  std::vector<Eigen::Vector3d> map_points_m;
  for (const bool is_map : {true, false}) {
    options.lateral_m = is_map ? 0.0 : 0.3;
    options.spacing_m = is_map ? 1.0 : 6.3;
    const Result<town::DriveSimulator> drive = town::DriveSimulator::make(town, options);
    for (std::size_t i = 0; i < drive->scan_count(); ++i) {
      const town::TownScan scan = drive->scan(i);
      const Pose T_map_lidar = scan.T_town_vehicle * options.sensor.T_vehicle_lidar;
      std::vector<Eigen::Vector3d> points_m;
      for (const town::LabelledPoint& point : scan.points) {
        if (!is_moving(point.label)) points_m.push_back(point.position_m.cast<double>());
      }
      if (is_map) {
        for (const Eigen::Vector3d& p_m : points_m) map_points_m.push_back(T_map_lidar * p_m);
      } else {
        street.scans.push_back(voxel_subsample(crop(points_m, 50.0), 1.0));
        street.T_map_scan.push_back(T_map_lidar);
      }
    }
  }
  const BuildNdtOptions build{.cell_m = 1.0};
  street.map = ndt_from_points(map_points_m, MapFrame{}, build, 1);
  return street;
}

Pose start_near(const Pose& T_map_truth, Random& random) {
  const double angle_rad = random.uniform(0.0, 6.28);
  const double radius_m = std::sqrt(random.uniform(0.0, 1.0));
  Pose offset = Pose::Identity();
  offset.translation() = Eigen::Vector3d(radius_m * std::cos(angle_rad),
                                         radius_m * std::sin(angle_rad), random.uniform(-0.1, 0.1));
  offset.linear() =
      Eigen::AngleAxisd(random.uniform(-0.052, 0.052), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T_map_truth * offset;
}

TEST(Localizer, InAStreetWithCellsOfAMetreLosesNoneOf64StartsAndEndsWithinHalfACentimetre) {
  const Street street = make_street();
  const Localizer localizer = make_localizer(street.map, {.is_annealed = true, .coarse_cells = 2});
  Random random(1);
  std::vector<double> errors_m;
  for (int trial = 0; trial < 64; ++trial) {
    const std::size_t i = static_cast<std::size_t>(trial) % street.scans.size();
    ScanForMatch scan = make_scan_for_match(localizer, street.scans[i]);
    const MatchResult result = localize(localizer, scan, start_near(street.T_map_scan[i], random));
    errors_m.push_back(
        (result.T_map_sensor.translation() - street.T_map_scan[i].translation()).norm());
  }
  std::sort(errors_m.begin(), errors_m.end());
  EXPECT_LT(errors_m[32], 0.005);
  EXPECT_LT(errors_m.back(), 0.5);
}

TEST(Localizer, SearchingFindsItsWayInALaneWhereMostStartsEndInAnotherOptimum) {
  const NdtMap map = simple_map(lane_points(1, 30.0, 120000), 2.0);
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(lane_points(2, 12.0, 6000), 0.5);
  const auto lost_starts = [&](const LocalizerOptions& options, const MatchOptions& limits = {}) {
    const Localizer localizer = make_localizer(map, options);
    ScanForMatch scan = make_scan_for_match(localizer, points_m);
    Random random(3);
    int lost = 0;
    for (int trial = 0; trial < 60; ++trial) {
      const MatchResult result =
          localize(localizer, scan, start_near(Pose::Identity(), random), limits);
      lost += result.T_map_sensor.translation().norm() > 0.3 ? 1 : 0;
    }
    return lost;
  };
  const int annealed = lost_starts({.is_annealed = true});
  const int searching = lost_starts({.is_annealed = true, .search_m = 1.25});
  EXPECT_GT(annealed, 12);
  EXPECT_LT(4 * searching, annealed);
  // A caller who knows the start better searches less.
  const LocalizerOptions options{.is_annealed = true, .search_m = 1.25};
  EXPECT_EQ(lost_starts(options, {.search_m = 0.0}), annealed);
  EXPECT_EQ(lost_starts(options, {.search_m = 5.0}), searching);
}

TEST(Localizer, SearchingWhereNothingIsLooseIsAnnealed) {
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 8000, 0.02), 1.0);
  const Pose start = Pose(Eigen::Translation3d(0.2, -0.1, 0.05));
  std::vector<MatchResult> results;
  for (const double search_m : {0.0, 1.25}) {
    const Localizer localizer =
        make_localizer(room_map(), {.is_annealed = true, .search_m = search_m});
    ScanForMatch scan = make_scan_for_match(localizer, points_m);
    results.push_back(localize(localizer, scan, start));
  }
  EXPECT_TRUE(results[0].T_map_sensor.isApprox(results[1].T_map_sensor, 0.0));
  EXPECT_EQ(results[0].work, results[1].work);
}

TEST(CoarseMap, PoolsACellFromAllOfItsPoints) {
  // Two cells of 1 m beside each other, in one of 2 m; the third is its neighbour below zero.
  std::vector<Eigen::Vector3d> points_m;
  Random random(4);
  for (int i = 0; i < 90; ++i) {
    const double x0 = i % 3 == 0 ? 0.0 : (i % 3 == 1 ? 1.0 : -1.0);
    points_m.push_back(random_vector(random, 0.05, 0.95) + Eigen::Vector3d(x0, 0.0, 0.0));
  }
  const NdtMap coarse = coarse_map(simple_map(points_m, 1.0), 2);
  const NdtMap expected = simple_map(points_m, 2.0);
  EXPECT_EQ(coarse.cell_m, 2.0);
  ASSERT_EQ(coarse.nds.size(), 2u);
  ASSERT_EQ(expected.nds.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(coarse.nds[i].key, expected.nds[i].key);
    EXPECT_EQ(coarse.nds[i].point_count, expected.nds[i].point_count);
    EXPECT_TRUE(coarse.nds[i].mean_m.isApprox(expected.nds[i].mean_m, 1e-12));
    EXPECT_TRUE(coarse.nds[i].covariance_m2.isApprox(expected.nds[i].covariance_m2, 1e-10));
  }
  EXPECT_TRUE(validate(coarse).has_value());
}

TEST(Localizer, PlainIsTheMatcherOnTheMapsOwnCells) {
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 8000, 0.02), 1.0);
  const Localizer localizer = make_localizer(room_map(), {});
  ScanForMatch scan = make_scan_for_match(localizer, points_m);
  const Pose start = Pose(Eigen::Translation3d(0.2, -0.1, 0.05));
  const MatchResult expected = match(make_match_grid(room_map()), points_m, start);
  const MatchResult result = localize(localizer, scan, start);
  EXPECT_TRUE(result.T_map_sensor.isApprox(expected.T_map_sensor, 0.0));
  EXPECT_EQ(result.work, expected.work);
}

void expect_same(const MatchResult& a, const MatchResult& b) {
  EXPECT_EQ(a.T_map_sensor.matrix(), b.T_map_sensor.matrix());
  EXPECT_EQ(a.score, b.score);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.work, b.work);
}

TEST(Localizer, ForSamplesSharesTheGridsAndMatchesAsOneThatIsMadeAnew) {
  Random random(17);
  for (const int coarse_cells : {1, 2}) {
    const Localizer own =
        make_localizer(room_map(), localizer_options(LocalizerKind::kSearching, coarse_cells));
    const Localizer shared = localizer_for_samples(own, room_map(), coarse_cells);
    const Localizer anew = make_localizer(room_map(), options_for_samples(coarse_cells));
    ASSERT_EQ(shared.levels.size(), anew.levels.size());
    for (std::size_t i = 0; i < own.levels.size(); ++i) {
      EXPECT_EQ(shared.levels[i].grid, own.levels[i].grid);
    }
    for (int trial = 0; trial < 10; ++trial) {
      const std::vector<Eigen::Vector3d> points_m = room_points(random.next(), 300, 0.02);
      const Pose start = random_pose(random, 0.8, 0.02);
      ScanForMatch a = make_scan_for_match(shared, points_m);
      ScanForMatch b = make_scan_for_match(anew, points_m);
      expect_same(localize(shared, a, start), localize(anew, b, start));
      expect_same(settle(shared, a, start), settle(anew, b, start));
    }
  }
}

TEST(Localizer, ScoresEveryLevelWithItsExactDerivatives) {
  Random random(7);
  // A single point, well inside its cell.
  const std::vector<Eigen::Vector3d> points_m = {{-11.25, 0.4, 0.6}};
  constexpr double kStep = 1e-5;
  for (const LocalizerOptions& options : kVariants) {
    const Localizer localizer = make_localizer(room_map(), options);
    for (const Localizer::Level& level : localizer.levels) {
      const Pose pose = random_pose(random, 0.05, 0.002);
      const MatchScore at = match_score(*level.grid, points_m, pose);
      ASSERT_GT(at.scored_points, 0u);
      for (int i = 0; i < 6; ++i) {
        const Vector6d motion = kStep * Vector6d::Unit(i);
        const MatchScore more = match_score(*level.grid, points_m, moved(pose, motion));
        const MatchScore less = match_score(*level.grid, points_m, moved(pose, -motion));
        EXPECT_NEAR(at.gradient[i], (more.score - less.score) / (2.0 * kStep),
                    1e-5 * (1.0 + at.gradient.cwiseAbs().maxCoeff()));
        if (i >= 3) continue;
        const Vector6d bend = (more.gradient - less.gradient) / (2.0 * kStep);
        EXPECT_LT((at.hessian.block<3, 1>(0, i) - bend.head<3>()).norm(),
                  1e-4 * (1.0 + at.hessian.cwiseAbs().maxCoeff()));
      }
    }
  }
}

TEST(Localizer, AllocatesNothing) {
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 8000, 0.02), 0.5);
  for (const LocalizerOptions& options : kVariants) {
    const Localizer localizer = make_localizer(room_map(), options);
    ScanForMatch scan = make_scan_for_match(localizer, points_m);
    const std::size_t before = allocation_count();
    localize(localizer, scan, Pose(Eigen::Translation3d(0.4, 0.2, 0.0)));
    EXPECT_EQ(allocation_count(), before);
  }
}

TEST(Localizer, SaysWhatIsWrongWithWhatItIsGiven) {
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 8000, 0.02), 1.0);
  std::vector<Eigen::Vector3d> floor_m;
  for (int x = -9; x <= 9; ++x) {
    for (int y = -5; y <= 5; ++y) floor_m.push_back({1.0 * x, 1.0 * y, -2.0 + 0.02 * x});
  }
  for (const LocalizerOptions& options : kVariants) {
    const Localizer localizer = make_localizer(room_map(), options);
    ScanForMatch none = make_scan_for_match(localizer, {});
    EXPECT_EQ(localize(localizer, none, Pose::Identity()).stop, MatchStop::kNoPoints);
    ScanForMatch scan = make_scan_for_match(localizer, points_m);
    const Pose far = Pose(Eigen::Translation3d(100.0, 0.0, 0.0));
    const MatchResult nowhere = localize(localizer, scan, far);
    EXPECT_EQ(nowhere.stop, MatchStop::kNoOverlap);
    EXPECT_TRUE(nowhere.T_map_sensor.isApprox(far, 0.0));
    ScanForMatch plane = make_scan_for_match(localizer, floor_m);
    const MatchResult flat = localize(localizer, plane, Pose(Eigen::Translation3d(0.0, 0.0, 0.1)));
    EXPECT_TRUE(is_finite(flat));
    EXPECT_LE(flat.iterations, 35);
    const Localizer empty = make_localizer(NdtMap{}, options);
    ScanForMatch lonely = make_scan_for_match(empty, points_m);
    EXPECT_EQ(localize(empty, lonely, Pose::Identity()).stop, MatchStop::kNoOverlap);
  }
}

TEST(Localizer, AThinLevelLeavesNoTraceInTheNextOne) {
  const std::vector<Eigen::Vector3d> points_m = voxel_subsample(room_points(22, 20000, 0.02), 0.3);
  ASSERT_GT(points_m.size(), 1100u);
  const Localizer localizer = make_localizer(room_map(), {.is_annealed = true, .coarse_cells = 2});
  ScanForMatch used = make_scan_for_match(localizer, points_m);
  EXPECT_LT(used.thin_count, points_m.size());
  EXPECT_EQ(used.thin_count % kKernelBatch, 0u);
  Random random(3);
  for (int trial = 0; trial < 10; ++trial) {
    const Pose start = random_pose(random, 0.3, 0.03);
    ScanForMatch fresh = make_scan_for_match(localizer, points_m);
    const MatchResult a = localize(localizer, used, start);
    EXPECT_TRUE(a.T_map_sensor.isApprox(localize(localizer, fresh, start).T_map_sensor, 0.0));
    EXPECT_LT(a.work, static_cast<std::uint64_t>(a.iterations) * points_m.size());
  }
}

}  // namespace
}  // namespace sightline
