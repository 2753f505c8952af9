#include "passes/matching/kernel_score.h"

#include <gtest/gtest.h>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "passes/matching/matcher.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

constexpr MatchKernel kVersions[] = {MatchKernel::kPortable, MatchKernel::kAvx2,
                                     MatchKernel::kAvx512};

std::string bits_of(const double* values, std::size_t count) {
  return {reinterpret_cast<const char*>(values), count * sizeof(double)};
}
std::string bits_of(const MatchScore& score) {
  return bits_of(&score.score, 1) + bits_of(&score.nearest_sum, 1) +
         bits_of(score.gradient.data(), 6) + bits_of(score.hessian.data(), 36) +
         std::to_string(score.scored_points);
}
std::string bits_of(const Pose& pose) { return bits_of(pose.matrix().data(), 16); }

MatchGrid room_grid(double cell_m) {
  return make_match_grid(simple_map(room_points(31, 15000, 0.03), cell_m));
}

TEST(KernelScore, GivesTheSameBitsInEveryVersion) {
  Random random(8);
  for (const double cell_m : {2.0, 1.0, 0.7}) {
    const MatchGrid grid = room_grid(cell_m);
    for (std::size_t count : {1u, 7u, 8u, 9u, 16u, 100u, 1024u, 3001u}) {
      const std::vector<Eigen::Vector3d> points_m = room_points(count, count, 0.05);
      const Pose pose = random_pose(random, 0.5, 0.1);
      ScanForMatch scan = make_scan_for_match(points_m);
      const std::string expected = bits_of(kernel_score(grid, scan, pose, MatchKernel::kPortable));
      for (const MatchKernel kernel : kVersions) {
        if (!is_supported(kernel)) continue;
        ScanForMatch fresh = make_scan_for_match(points_m);
        EXPECT_EQ(bits_of(kernel_score(grid, fresh, pose, kernel)), expected)
            << "version " << static_cast<int>(kernel) << ", " << count << " points";
      }
    }
  }
}

TEST(KernelScore, AgreesWithTheExactScore) {
  Random random(9);
  const MatchGrid grids[] = {room_grid(2.0), room_grid(1.0)};
  for (int trial = 0; trial < 40; ++trial) {
    const MatchGrid& grid = grids[trial % 2];
    const Pose pose = random_pose(random, 1.0, 0.2);
    ScanForMatch scan = make_scan_for_match(room_points(60, 2000, 0.03));
    const MatchScore exact = match_score(grid, scan.points_m, pose);
    const MatchScore fast = kernel_score(grid, scan, pose, MatchKernel::kFastest);
    EXPECT_EQ(fast.scored_points, exact.scored_points);
    EXPECT_NEAR(fast.score, exact.score, 2e-6 * exact.score);
    EXPECT_NEAR(fast.nearest_sum, exact.nearest_sum, 2e-6 * exact.score);
    // Gradients and curvatures cancel: what counts is their error as a displacement.
    EXPECT_LT((fast.hessian - exact.hessian).cwiseAbs().maxCoeff(),
              1e-5 * exact.hessian.cwiseAbs().maxCoeff());
    EXPECT_LT((fast.gradient - exact.gradient).cwiseAbs().maxCoeff(),
              1e-6 * exact.hessian.cwiseAbs().maxCoeff());
  }
}

// A map of those NDs in order, as the rolling grid has them: each with an information of its own.
MatchGrid grid_of(const std::map<CellKey, Nd>& nds) {
  NdtMap map;
  map.cell_m = 1.0;
  for (const auto& [key, nd] : nds) map.nds.push_back(nd);
  return make_match_grid(map);
}

TEST(KernelScore, OfARollingGridIsThatOfAGridOfTheSameNds) {
  const NdtMap rooms[] = {simple_map(room_points(31, 15000, 0.03), 1.0),
                          simple_map(room_points(32, 15000, 0.05), 1.0)};
  Random random(12);
  RollingMatchGrid rolling(1.0);
  const auto information_per_m2 = [](const Nd& nd) -> Eigen::Matrix3d {
    return regularised_covariance_m2(nd).inverse();
  };
  std::map<CellKey, Nd> nds;
  std::uint32_t fewest = 1000;
  ScanForMatch scan = make_scan_for_match(room_points(33, 2000, 0.03));
  for (int round = 0; round < 60; ++round) {
    const bool empties = round % 20 >= 12;
    for (int i = 0; i < 150; ++i) {
      const NdtMap& room = rooms[random.below(2)];
      const Nd& nd = room.nds[random.below(room.nds.size())];
      if (empties || random.below(4) == 0) {
        rolling.take_away(nd.key);
        nds.erase(nd.key);
        continue;
      }
      std::map<CellKey, Nd> some{{nd.key, nd}};
      const std::size_t more = random.below(50) == 0 ? 100 : 0;
      for (std::size_t k = 0; k < more; ++k) {
        const Nd& other = room.nds[random.below(room.nds.size())];
        some.insert_or_assign(other.key, other);
      }
      std::vector<Nd> put;
      for (const auto& [key, one] : some) put.push_back(one);
      rolling.put(put, information_per_m2);
      for (const Nd& one : put) nds.insert_or_assign(one.key, one);
    }
    rolling.finish();
    const MatchGrid expected = grid_of(nds);
    EXPECT_LE(rolling.grid().cells.size(), 2 * expected.cells.size() + 1);
    const Pose pose = random_pose(random, 0.5, 0.1);
    ScanForMatch fresh = make_scan_for_match(scan.points_m);
    const MatchScore score = kernel_score(expected, fresh, pose, MatchKernel::kFastest);
    fewest = std::min(fewest, score.scored_points);
    // The same scan goes on to be used: what it remembers of cells is not what they are now.
    EXPECT_EQ(bits_of(kernel_score(rolling.grid(), scan, pose, MatchKernel::kFastest)),
              bits_of(score));
    EXPECT_EQ(bits_of(match_score(rolling.grid(), scan.points_m, pose)),
              bits_of(match_score(expected, scan.points_m, pose)));
  }
  EXPECT_LT(fewest, 900u);  // rooms did empty
}

TEST(KernelScore, OfARollingGridLeavesOutWhatNoFloatCanHold) {
  NdtMap map = simple_map(room_points(31, 15000, 0.03), 1.0);
  RollingMatchGrid rolling(1.0);
  const std::span<const Nd> first = std::span(map.nds).first(1);
  rolling.put(first, [](const Nd&) -> Eigen::Matrix3d { return Eigen::Matrix3d::Identity(); });
  rolling.put(first,
              [](const Nd&) -> Eigen::Matrix3d { return 1e10 * Eigen::Matrix3d::Identity(); });
  rolling.finish();
  EXPECT_EQ(find_cell(rolling.grid(), map.nds.front().key), MatchGrid::kNone);
}

TEST(KernelScore, RemembersCellsFromGridToGridOfTheSameCellsAlone) {
  // Sharp and blurred NDs of one map number its cells alike; another map, and other cells, do not.
  const NdtMap room = simple_map(room_points(31, 15000, 0.03), 2.0);
  const NdtMap part = simple_map(room_points(31, 4000, 0.03), 2.0);
  const MatchGrid grids[] = {
      make_match_grid(room),
      make_match_grid(room,
                      [](const Nd&) -> Eigen::Matrix3d { return Eigen::Matrix3d::Identity(); }),
      make_match_grid(part), room_grid(1.0), make_match_grid(NdtMap{})};
  EXPECT_EQ(grids[0].cells_digest, grids[1].cells_digest);
  EXPECT_NE(grids[0].cells_digest, grids[2].cells_digest);
  Random random(12);
  const std::vector<Eigen::Vector3d> points_m = room_points(3, 500, 0.02);
  ScanForMatch used = make_scan_for_match(points_m);
  for (int trial = 0; trial < 60; ++trial) {
    const MatchGrid& grid = grids[random.below(std::size(grids))];
    const Pose pose = random_pose(random, 1.0, 0.2);
    ScanForMatch fresh = make_scan_for_match(points_m);
    EXPECT_EQ(bits_of(kernel_score(grid, used, pose, MatchKernel::kFastest)),
              bits_of(kernel_score(grid, fresh, pose, MatchKernel::kFastest)));
  }
}

TEST(KernelScore, AloneIsTheSameNumberInEveryVersion) {
  const MatchGrid grid = room_grid(2.0);
  Random random(13);
  for (const std::size_t count : {1u, 16u, 100u, 1024u, 3001u}) {
    ScanForMatch scan = make_scan_for_match(room_points(count, count, 0.05));
    const Pose pose = random_pose(random, 0.5, 0.1);
    for (const MatchKernel kernel :
         {MatchKernel::kPortable, MatchKernel::kAvx2, MatchKernel::kAvx512, MatchKernel::kExact}) {
      if (!is_supported(kernel)) continue;
      EXPECT_EQ(kernel_score_alone(grid, scan, count, pose, kernel),
                kernel_score(grid, scan, count, pose, kernel).score)
          << "version " << static_cast<int>(kernel) << ", " << count << " points";
    }
  }
}

TEST(KernelScore, StaysFiniteHoweverFarOrSharp) {
  NdtMap map = simple_map(room_points(31, 5000, 1e-7), 2.0);
  for (Nd& nd : map.nds) nd.eigenvalues_m2 *= 1e-6;
  const MatchGrid grid = make_match_grid(map);
  ScanForMatch scan = make_scan_for_match(room_points(3, 100, 0.5));
  for (const double far_m : {0.0, 1e3, 1e9, 1e30, 1e300}) {
    const Pose pose = Pose(Eigen::Translation3d(far_m, -far_m, 0.0));
    const MatchScore score = kernel_score(grid, scan, pose, MatchKernel::kFastest);
    EXPECT_TRUE(std::isfinite(score.score));
    EXPECT_TRUE(score.gradient.allFinite());
    EXPECT_TRUE(score.hessian.allFinite());
    if (far_m > 0.0) {
      EXPECT_EQ(score.scored_points, 0u);
    }
  }
}

TEST(Match, EndsAtTheSameBitsInEveryVersionAndNearTheExactOne) {
  const MatchGrid grid = room_grid(2.0);
  const std::vector<Eigen::Vector3d> points_m = room_points(4, 500, 0.02);
  Random random(6);
  for (int trial = 0; trial < 8; ++trial) {
    const Pose start = random_pose(random, 0.4, 0.05);
    MatchOptions options{.kernel = MatchKernel::kExact};
    const MatchResult exact = match(grid, points_m, start, options);
    options.kernel = MatchKernel::kPortable;
    const MatchResult expected = match(grid, points_m, start, options);
    EXPECT_LT((exact.T_map_sensor.translation() - expected.T_map_sensor.translation()).norm(),
              1e-4);
    for (const MatchKernel kernel : kVersions) {
      if (!is_supported(kernel)) continue;
      options.kernel = kernel;
      const MatchResult result = match(grid, points_m, start, options);
      EXPECT_EQ(bits_of(result.T_map_sensor), bits_of(expected.T_map_sensor));
      EXPECT_EQ(result.iterations, expected.iterations);
    }
  }
}

}  // namespace
}  // namespace sightline
