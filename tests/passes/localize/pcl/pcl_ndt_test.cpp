#include "passes/localize/pcl/pcl_ndt.h"

#include <gtest/gtest.h>

#include "passes/map/build_ndt.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> scan_at(const Pose& T_map_scan) {
  return transformed(T_map_scan.inverse(), room_points(2, 1500, 0.02));
}

double apart_m(const Pose& a, const Pose& b) { return (a.translation() - b.translation()).norm(); }

TEST(PclNdt, EndsWherePclEndsThatWasGivenThePoints) {
  if (!has_pcl_ndt()) GTEST_SKIP() << "built without PCL";
  const std::vector<Eigen::Vector3d> points_m = room_points(1, 30000, 0.02);
  const NdtMap map = ndt_from_points(points_m, MapFrame{}, BuildNdtOptions{}, 1);
  PclNdt of_nds(map, Eigen::Vector3d::Zero());
  PclNdt of_points(points_m, map.cell_m, 10);  // as many as an ND of the map needs
  Random random(7);
  double off_before_m = 0.0, off_after_m = 0.0;
  for (int i = 0; i < 4; ++i) {
    const Pose truth = random_pose(random, 2.0, 0.1);
    const Pose start = truth * random_pose(random, 0.3, 0.02);
    for (PclNdt* ndt : {&of_nds, &of_points}) ndt->set_scan(scan_at(truth));
    const PclMatch found = of_nds.match(start);
    const PclMatch expected = of_points.match(start);
    EXPECT_LT(apart_m(found.T_map_scan, expected.T_map_scan), 1e-3) << i;
    EXPECT_NEAR(found.iterations, expected.iterations, 2) << i;
    EXPECT_GT(found.iterations, 1) << "an epsilon that stops at the start says nothing";
    off_before_m += apart_m(start, truth);
    off_after_m += apart_m(found.T_map_scan, truth);
  }
  EXPECT_LT(off_after_m, 0.7 * off_before_m);
}

TEST(PclNdt, GivesTheSameBitsAgain) {
  if (!has_pcl_ndt()) GTEST_SKIP() << "built without PCL";
  const NdtMap map = ndt_from_points(room_points(1, 30000, 0.02), MapFrame{}, BuildNdtOptions{}, 1);
  const Pose start(Eigen::Translation3d(0.2, -0.1, 0.0));
  const auto found = [&] {
    PclNdt ndt(map, Eigen::Vector3d::Zero());
    ndt.set_scan(scan_at(Pose::Identity()));
    return ndt.match(start).T_map_scan.matrix();
  };
  EXPECT_EQ(found(), found());
}

TEST(PclNdt, StaysAtTheStartWhereThereIsNothingToMatch) {
  if (!has_pcl_ndt()) GTEST_SKIP() << "built without PCL";
  const NdtMap map = ndt_from_points(room_points(1, 30000, 0.02), MapFrame{}, BuildNdtOptions{}, 1);
  const Pose start(Eigen::Translation3d(1.0, 2.0, 0.0));
  PclNdt no_points(map, Eigen::Vector3d::Zero());
  no_points.set_scan({});
  EXPECT_EQ(apart_m(no_points.match(start).T_map_scan, start), 0.0);
  PclNdt no_nds(map, Eigen::Vector3d(1000.0, 0.0, 0.0));
  no_nds.set_scan(scan_at(Pose::Identity()));
  EXPECT_EQ(apart_m(no_nds.match(start).T_map_scan, start), 0.0);
}

}  // namespace
}  // namespace sightline
