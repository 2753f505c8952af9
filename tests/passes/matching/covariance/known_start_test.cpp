#include "passes/matching/covariance/known_start.h"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "passes/matching/look_cutter.h"
#include "tests/passes/matching/allocation_counter.h"
#include "tests/passes/matching/covariance/random_positive.h"
#include "tests/passes/matching/random_scene.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

Vector6d small_motion(Random& random) {
  Vector6d motion;
  for (int i = 0; i < 6; ++i) motion[i] = 0.01 * random.normal();
  return motion;
}

TEST(MotionBetween, IsWhatMovesOnePoseToTheOther) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose from = moved(pose_at(3.0, -2.0, 0.7), small_motion(random));
    const Vector6d motion = small_motion(random);
    EXPECT_LT((motion_between(from, moved(from, motion)) - motion).norm(), 1e-9);
  }
}

// x = (I + P^-1)^-1 (I z + P^-1 x0).
TEST(PoseOfKnownStart, IsTheMeanOfMatchAndStartWeightedByTheirInformation) {
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix6d information = random_positive(random, 0.1);
    KnownStart start{Pose::Identity(), random_positive(random, 0.1)};
    const Vector6d found = small_motion(random);
    const PoseEstimate estimate =
        pose_of_known_start(moved(start.T_map_vehicle, found), information, start);
    const Matrix6d covariance = (information + start.covariance.inverse()).inverse();
    EXPECT_LT((estimate.covariance - covariance).norm(), 1e-8);
    const Vector6d expected = covariance * information * found;
    const Vector6d motion = motion_between(start.T_map_vehicle, estimate.T_map_vehicle);
    EXPECT_LT((motion - expected).norm(), 2e-4);  // turns do not quite commute
  }
}

TEST(PoseOfKnownStart, WithoutInformationIsTheStart) {
  Random random(3);
  const KnownStart start{pose_at(1.0, 2.0, 0.3), 0.04 * Matrix6d::Identity()};
  const Pose found = moved(start.T_map_vehicle, 10.0 * small_motion(random));
  const PoseEstimate none = pose_of_known_start(found, Matrix6d::Zero(), start);
  EXPECT_TRUE(none.T_map_vehicle.isApprox(start.T_map_vehicle, 1e-6));
  EXPECT_EQ(none.covariance, start.covariance);
  const PoseEstimate exact = pose_of_known_start(found, 1e6 * Matrix6d::Identity(),
                                                 {start.T_map_vehicle, Matrix6d::Zero()});
  EXPECT_TRUE(exact.T_map_vehicle.isApprox(start.T_map_vehicle, 1e-6));
  EXPECT_TRUE(exact.covariance.isZero(0.0));
}

TEST(SearchOfStart, IsThreeDeviationsOfTheLeastKnownHorizontalDirection) {
  Matrix6d start = Matrix6d::Zero();
  start.topLeftCorner<2, 2>() << 0.025, 0.015, 0.015, 0.025;  // 0.2 m and 0.1 m, turned
  EXPECT_NEAR(search_of_start_m(start), 0.6, 1e-12);
  EXPECT_EQ(search_of_start_m(Matrix6d::Zero()), 0.0);
}

// Two walls without end, whose rings and cells still have a score along them.
struct Walls {
  Walls() {
    for (int k = -20; k <= 20; ++k) {
      const Pose pose = pose_at(k, 0.0, 0.0);
      for (const Eigen::Vector3d& point_m : scan_at(pose)) points_m.push_back(pose * point_m);
    }
    map = simple_map(points_m, 2.0);
    own = make_localizer(map, localizer_options(LocalizerKind::kSearching));
    samples = localizer_for_samples(own, map);
    structures = StructureMap(map, own.levels.back().grid);
  }

  static std::vector<Eigen::Vector3d> scan_at(const Pose& T_map_vehicle) {
    const BoxWorld walls{
        {{{-200.0, 6.7, 0.0}, {200.0, 8.0, 6.0}}, {{-200.0, -8.0, 0.0}, {200.0, -6.7, 6.0}}}};
    const Pose sensor = lidar_at(0.0, 0.0, 0.0);
    std::vector<Eigen::Vector3d> points_m = scan_world(walls, T_map_vehicle * sensor, 1.0).points_m;
    for (Eigen::Vector3d& point_m : points_m) point_m = sensor * point_m;
    return points_m;
  }

  std::vector<Eigen::Vector3d> points_m;
  NdtMap map;
  Localizer own;
  Localizer samples;
  StructureMap structures;
};

TEST(EndOfMatch, KeepsTheStartAlongWallsAndMovesAcrossThem) {
  const Walls walls;
  const SensorProfile sensor;  // at the vehicle
  LookMatcher matcher({walls.own, walls.samples, sensor});
  StructureObserver memory;
  const Pose truth = pose_at(0.4, 0.3, 0.0);
  Scan scan;
  scan.points_m = Walls::scan_at(truth);
  matcher.take(scan, every_return(40.0));
  KnownStart start{pose_at(0.25, 0.45, 0.0), Matrix6d::Zero()};
  start.covariance.diagonal() << 0.02, 0.02, 0.0025, 1e-4, 1e-4, 1e-4;
  const MatchResult found = matcher.match(start.T_map_vehicle, search_of_start_m(start.covariance));
  const MatchEnd known = end_of_match(found, matcher.scan(), &start, walls.structures,
                                      default_information_scale(), memory);
  const Eigen::Vector3d end_m = known.estimate.T_map_vehicle.translation();
  EXPECT_NEAR(end_m.x(), 0.25, 0.02);
  EXPECT_NEAR(end_m.y(), 0.3, 0.02);
  EXPECT_GT(known.estimate.covariance(0, 0), 0.9 * 0.02);
  EXPECT_LT(known.estimate.covariance(1, 1), 0.1 * 0.02);
  EXPECT_EQ(known.weak & 3u, 1u);
  const MatchEnd unknown = end_of_match(found, matcher.scan(), nullptr, walls.structures,
                                        default_information_scale(), memory);
  EXPECT_EQ(unknown.estimate.T_map_vehicle.matrix(), found.T_map_sensor.matrix());
  EXPECT_EQ(unknown.information, known.information);
  const std::size_t before = allocation_count();
  end_of_match(found, matcher.scan(), &start, walls.structures, default_information_scale(),
               memory);
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace sightline
