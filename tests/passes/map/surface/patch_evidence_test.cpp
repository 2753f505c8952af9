#include "passes/map/surface/patch_evidence.h"

#include <gtest/gtest.h>
#include <numeric>

#include "formats/base/random.h"

namespace sightline {
namespace {

// Upright, 10 m ahead along x: squares count columns along -y and rows up or down.
SurfacePatch wall() {
  SurfacePatch patch;
  patch.key = {20, 0, 0};
  patch.centre_m = {10.2, 0.25, 0.25};
  patch.normal = Eigen::Vector3d::UnitX();
  patch.half_side_m = 0.4;
  return patch;
}

SquareCounts seen(const SurfacePatch& patch, const SeenScan& scan) {
  const PatchGrid grid(std::vector<SurfacePatch>{patch}, 0.5);
  PatchEvidence evidence(grid, 1);
  evidence.add(std::vector<SeenScan>{scan}, 1);
  evidence.finish(1);
  return evidence.counts()[0];
}

int sum(const std::array<std::uint8_t, kSquaresOfPatch>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0);
}

SeenScan scan_of(std::vector<Eigen::Vector3d> points_m) {
  return {{std::move(points_m), {}}, true};
}

TEST(PatchEvidence, CountsAReturnInTheSquareWhereItLies) {
  const SquareCounts counts = seen(wall(), scan_of({{10.25, 0.3, 0.3}}));
  EXPECT_EQ(sum(counts.returns), 1);
  EXPECT_EQ(sum(counts.passes), 0);
  const int square = PatchPlane(wall()).square_of({10.2, 0.3, 0.3});
  ASSERT_GE(square, 0);
  EXPECT_EQ(counts.returns[static_cast<std::size_t>(square)], 1);
}

TEST(PatchEvidence, CountsARayThatEndsBehindThePatch) {
  const SquareCounts counts = seen(wall(), scan_of({{20.4, 0.5, 0.5}}));
  EXPECT_EQ(sum(counts.returns), 0);
  EXPECT_EQ(sum(counts.passes), 1);
  const int square = PatchPlane(wall()).square_of({10.2, 0.25, 0.25});
  EXPECT_EQ(counts.passes[static_cast<std::size_t>(square)], 1);
}

TEST(PatchEvidence, SaysNothingOfRaysThatEndAtThePatchOrBeforeItOrPassBeside) {
  for (const Eigen::Vector3d& point_m :
       {Eigen::Vector3d(10.35, 0.25, 0.25), Eigen::Vector3d(5.0, 0.1, 0.1),
        Eigen::Vector3d(20.0, 3.0, 0.0)}) {
    EXPECT_EQ(sum(seen(wall(), scan_of({point_m})).passes), 0);
  }
}

TEST(PatchEvidence, SaysNothingOfAPatchSeenEdgeOn) {
  SurfacePatch ground = wall();
  ground.centre_m = {10.2, 0.25, -0.5};
  ground.normal = Eigen::Vector3d(0.0, 0.0, 1.0);
  EXPECT_EQ(sum(seen(ground, scan_of({{20.4, 0.5, -1.0}})).passes), 0);
}

TEST(PatchEvidence, FollowsNoRayWithoutAnOrigin) {
  SeenScan scan = scan_of({{20.4, 0.5, 0.5}, {10.2, 0.25, 0.25}});
  scan.has_origin = false;
  const SquareCounts counts = seen(wall(), scan);
  EXPECT_EQ(sum(counts.passes), 0);
  EXPECT_EQ(sum(counts.returns), 1);
}

TEST(PatchEvidence, CountsTheSamePassesWhereverTheCellsOfItsGridBegin) {
  Random random(5);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 500; ++i) {
    points_m.emplace_back(20.0, random.uniform(-1.0, 2.0), random.uniform(-1.0, 2.0));
  }
  SurfacePatch beside_the_sensor = wall();
  beside_the_sensor.centre_m = {-0.2, 3.0, 0.3};
  const SquareCounts alone = seen(wall(), scan_of(points_m));
  const PatchGrid grid(std::vector<SurfacePatch>{beside_the_sensor, wall()}, 0.5);
  PatchEvidence evidence(grid, 2);
  evidence.add(std::vector<SeenScan>{scan_of(points_m)}, 1);
  evidence.finish(1);
  EXPECT_GT(sum(alone.passes), 50);
  EXPECT_EQ(evidence.counts()[1].passes, alone.passes);
}

TEST(PatchEvidence, CountsTheRayOfAReturnThatMovedButNotTheReturn) {
  // One return on the wall and one far behind it, and the same where both have moved.
  SeenScan scan = scan_of({{10.25, 0.3, 0.3}, {30.6, 0.9, 0.9}});
  const SquareCounts stood = seen(wall(), scan);
  scan.returns.has_moved = {1, 1};
  const SquareCounts moved = seen(wall(), scan);
  EXPECT_EQ(sum(stood.returns), 1);
  EXPECT_EQ(sum(moved.returns), 0);
  EXPECT_EQ(sum(stood.passes), 1);
  EXPECT_EQ(moved.passes, stood.passes);
}

TEST(PatchEvidence, CountsAPassOnceHoweverManyCellsThePatchReachesInto) {
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    SurfacePatch patch = wall();
    patch.centre_m += Eigen::Vector3d(random.uniform(), random.uniform(), random.uniform());
    patch.half_side_m = 1.4;
    const Eigen::Vector3d through_m =
        patch.centre_m + Eigen::Vector3d(0.0, random.uniform(-1.3, 1.3), random.uniform(-1.3, 1.3));
    EXPECT_EQ(sum(seen(patch, scan_of({2.0 * through_m})).passes), 1);
  }
}

TEST(PatchEvidence, IsTheSameForAnyNumberOfThreads) {
  Random random(4);
  std::vector<SurfacePatch> patches(200, wall());
  for (SurfacePatch& patch : patches) {
    patch.centre_m = {random.uniform(5.0, 9.0), random.uniform(-4.0, 4.0),
                      random.uniform(0.0, 2.0)};
  }
  std::vector<SeenScan> scans(20);
  for (SeenScan& scan : scans) {
    scan.has_origin = true;
    for (int i = 0; i < 500; ++i) {
      scan.returns.points_m.emplace_back(random.uniform(4.0, 20.0), random.uniform(-8.0, 8.0),
                                         random.uniform(0.0, 3.0));
    }
  }
  const PatchGrid grid(patches, 0.5);
  PatchEvidence one(grid, patches.size());
  PatchEvidence three(grid, patches.size());
  one.add(scans, 1);
  three.add(scans, 3);
  one.finish(1);
  three.finish(3);
  int passes = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    EXPECT_EQ(one.counts()[i].returns, three.counts()[i].returns);
    EXPECT_EQ(one.counts()[i].passes, three.counts()[i].passes);
    passes += sum(one.counts()[i].passes);
  }
  EXPECT_GT(passes, 100);
}

// More than are gathered before they are counted.
TEST(PatchEvidence, CountsEachOfManyReturnsWhereverItsScanEnds) {
  Random random(6);
  std::vector<SurfacePatch> patches(300, wall());
  for (SurfacePatch& patch : patches) {
    patch.centre_m = {random.uniform(5.0, 9.0), random.uniform(-9.0, 9.0),
                      random.uniform(0.0, 6.0)};
  }
  const PatchGrid grid(patches, 0.5);
  PatchEvidence evidence(grid, patches.size());
  std::vector<SquareCounts> expected(patches.size());
  for (int i = 0; i < 4; ++i) {
    SeenScan scan;
    for (int j = 0; j < 100000; ++j) {
      const Eigen::Vector3d point_m(random.uniform(4.0, 10.0), random.uniform(-10.0, 10.0),
                                    random.uniform(-1.0, 7.0));
      scan.returns.points_m.push_back(point_m);
      for (const std::uint32_t patch : grid.patches_at(cell_key(point_m, 0.5))) {
        const int square = grid.plane(patch).square_of_return(point_m);
        if (square < 0) continue;
        std::uint8_t& counter = expected[patch].returns[static_cast<std::size_t>(square)];
        if (counter < 255) ++counter;
      }
    }
    evidence.add(std::span(&scan, 1), 2);
  }
  evidence.finish(2);
  int returns = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    EXPECT_EQ(evidence.counts()[i].returns, expected[i].returns) << "patch " << i;
    returns += sum(expected[i].returns);
  }
  EXPECT_GT(returns, 10000);
}

}  // namespace
}  // namespace sightline
