#include "passes/map/build_ndt.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <map>

#include "formats/base/random.h"
#include "tests/support/test_context.h"
#include "tests/support/test_files.h"
#include "tests/support/toy_world.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

SurfacePoints points_of(std::vector<Eigen::Vector3d> points_m) {
  SurfacePoints points;
  points.points_m = std::move(points_m);
  return points;
}

// Clumps, so that cells hold many points, with some far from the origin.
SurfacePoints random_points(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  SurfacePoints points;
  while (points.points_m.size() < count) {
    const Eigen::Vector3d centre_m(random.uniform(-150.0, 150.0), random.uniform(-150.0, 150.0),
                                   random.uniform(-10.0, 10.0));
    for (int i = 0; i < 100; ++i) {
      points.points_m.emplace_back(
          centre_m + Eigen::Vector3d(random.normal(), random.normal(), 0.1 * random.normal()));
    }
  }
  return points;
}

NdtMap must_build(const SurfacePoints& points, const BuildNdtOptions& options = {},
                  int threads = 1) {
  return value_of(whole_rows(build_ndt(TestContext(threads), options, points)));
}

TEST(BuildNdt, GivesTheMomentsOfASmallExample) {
  // Corners of a rectangle of 1.0 by 0.4 m at height 1, three times each: 12 points.
  std::vector<Eigen::Vector3d> points_m;
  for (int repeat = 0; repeat < 3; ++repeat) {
    for (const double x : {0.5, 1.5}) {
      for (const double y : {0.8, 1.2}) points_m.emplace_back(x, y, 1.0);
    }
  }
  const NdtMap map = must_build(points_of(points_m));
  ASSERT_EQ(map.nds.size(), 1U);
  const Nd& nd = map.nds[0];
  EXPECT_EQ(nd.key, (CellKey{0, 0, 0}));
  EXPECT_EQ(nd.point_count, 12U);
  EXPECT_TRUE(nd.mean_m.isApprox(Eigen::Vector3d(1.0, 1.0, 1.0), 1e-15));
  // 12 x 0.5^2 / 11 along x, 12 x 0.2^2 / 11 along y.
  EXPECT_NEAR(nd.covariance_m2(0, 0), 3.0 / 11.0, 1e-15);
  EXPECT_NEAR(nd.covariance_m2(1, 1), 0.48 / 11.0, 1e-15);
  EXPECT_NEAR(nd.covariance_m2(0, 1), 0.0, 1e-15);
  EXPECT_NEAR(nd.eigenvalues_m2[0], 3.0 / 11.0, 1e-15);
  EXPECT_GE(nd.eigenvalues_m2[2], 0.0);
  EXPECT_NEAR(std::abs(nd.eigenvectors(0, 0)), 1.0, 1e-12);
}

TEST(BuildNdt, EqualsTextbookMomentsOfEveryCellOfRandomPoints) {
  const SurfacePoints points = random_points(1, 20000);
  std::map<CellKey, std::vector<Eigen::Vector3d>> cells;
  for (const Eigen::Vector3d& point_m : points.points_m) {
    cells[{static_cast<int>(std::floor(point_m.x() / 2.0)),
           static_cast<int>(std::floor(point_m.y() / 2.0)),
           static_cast<int>(std::floor(point_m.z() / 2.0))}]
        .push_back(point_m);
  }
  const NdtMap map = must_build(points);
  std::size_t expected_count = 0;
  for (const auto& [key, members] : cells) expected_count += members.size() >= 10 ? 1 : 0;
  ASSERT_EQ(map.nds.size(), expected_count);
  for (const Nd& nd : map.nds) {
    const std::vector<Eigen::Vector3d>& members = cells.at(nd.key);
    ASSERT_EQ(nd.point_count, members.size());
    Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& point_m : members) mean_m += point_m;
    mean_m /= static_cast<double>(members.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& point_m : members) {
      covariance += (point_m - mean_m) * (point_m - mean_m).transpose();
    }
    covariance /= static_cast<double>(members.size() - 1);
    EXPECT_LT((nd.mean_m - mean_m).norm(), 1e-11);
    EXPECT_LT((nd.covariance_m2 - covariance).norm(), 1e-11);
    const Eigen::Matrix3d rebuilt =
        nd.eigenvectors * nd.eigenvalues_m2.asDiagonal() * nd.eigenvectors.transpose();
    EXPECT_LT((rebuilt - covariance).norm(), 1e-11);
  }
}

TEST(BuildNdt, GivesTheSameBytesForAnyNumberOfThreads) {
  const SurfacePoints points = random_points(2, 200000);
  const std::vector<std::byte> one = to_bytes(must_build(points, {}, 1));
  EXPECT_EQ(one, to_bytes(must_build(points, {}, 2)));
  EXPECT_EQ(one, to_bytes(must_build(points, {}, 5)));
}

TEST(BuildNdt, GivesTheSameCellsHoweverTheMapIsCutIntoTiles) {
  const SurfacePoints points = random_points(3, 50000);
  const NdtMap small = must_build(points, {2.0, 32.0, 10});
  const NdtMap large = must_build(points, {2.0, 128.0, 10});
  ASSERT_EQ(small.nds.size(), large.nds.size());
  std::map<CellKey, const Nd*> by_key;
  for (const Nd& nd : small.nds) by_key[nd.key] = &nd;
  for (const Nd& nd : large.nds) {
    EXPECT_EQ(nd.mean_m, by_key.at(nd.key)->mean_m);
    EXPECT_EQ(nd.covariance_m2, by_key.at(nd.key)->covariance_m2);
  }
}

TEST(BuildNdt, MakesValidMapsOfAnyCellSize) {
  for (const double cell_m : {0.25, 0.4, 1.0, 2.0, 3.2}) {
    const SurfacePoints points = random_points(4, 30000);
    const NdtMap map = must_build(points, {cell_m, 64.0, 3});
    EXPECT_TRUE(validate(map).has_value()) << cell_m;
    EXPECT_EQ(map.point_count, points.points_m.size());
  }
}

TEST(BuildNdt, KeepsAMeanThatRoundsOntoAnUpperFaceInsideItsCell) {
  // So little below zero that it vanishes beside the cell's centre at -1: the mean comes out as 0.
  const double below_m = -1e-20;
  std::vector<Eigen::Vector3d> points_m(20, Eigen::Vector3d(below_m, 1.0, below_m));
  for (int i = 0; i < 10; ++i) points_m[static_cast<std::size_t>(i)].y() = 0.5;
  const NdtMap map = must_build(points_of(points_m));
  ASSERT_EQ(map.nds.size(), 1U);
  EXPECT_EQ(map.nds[0].key, (CellKey{-1, 0, -1}));
  EXPECT_LT(map.nds[0].mean_m.x(), 0.0);
  EXPECT_LT(map.nds[0].mean_m.z(), 0.0);
  EXPECT_TRUE(validate(map).has_value());
}

TEST(BuildNdt, CountsAndWarnsOfCellsThatAreTooSparseOrHaveNoExtent) {
  std::vector<Eigen::Vector3d> points_m(15, Eigen::Vector3d(11.0, 1.0, 1.0));  // no extent
  points_m.resize(20, Eigen::Vector3d(21.0, 1.0, 1.0));                        // sparse
  for (int i = 0; i < 10; ++i) points_m.emplace_back(0.1 * i, 1.0, 1.0);
  TestContext ctx;
  const NdtMap map = value_of(whole_rows(build_ndt(ctx, {}, points_of(points_m))));
  EXPECT_EQ(map.nds.size(), 1U);
  EXPECT_EQ(map.sparse_cell_count, 1U);
  EXPECT_EQ(map.degenerate_cell_count, 1U);
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_NE(ctx.warnings[0].find("1 cells have fewer than 10 points"), std::string::npos);
}

TEST(BuildNdt, SeesWallsAndGroundAsPlanesAndAPoleAsALine) {
  const ToyWorld world = draw_world(R"(
##########
..........
....o.....
..........
)");
  const NdtMap map = must_build(world.points);
  int poles = 0;
  for (const Nd& nd : map.nds) {
    const bool is_high = nd.key.z == 1;
    if (is_high && nd.key.x == 2 && nd.key.y == 0) {
      EXPECT_EQ(dimension_class(nd), 1);
      EXPECT_NEAR(std::abs(nd.eigenvectors.col(0).z()), 1.0, 1e-9);
      ++poles;
    }
  }
  EXPECT_EQ(poles, 1);
}

TEST(BuildNdt, RefusesATileThatIsNoMultipleOfTheCell) {
  EXPECT_EQ(
      failure_of(whole_rows(build_ndt(TestContext(), {3.0, 64.0, 10}, random_points(5, 1000))))
          .code,
      ErrorCode::kBadValue);
}

TEST(BuildNdt, RefusesPointsOfWhichNoCellIsValid) {
  EXPECT_EQ(failure_of(whole_rows(build_ndt(TestContext(), {}, SurfacePoints{}))).code,
            ErrorCode::kEmptyMap);
}

TEST(BuildNdt, RefusesAPointThatTheGridCannotHold) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e15}) {
    SurfacePoints points = random_points(6, 1000);
    points.points_m[17].z() = bad;
    const Error refused = failure_of(whole_rows(build_ndt(TestContext(), {}, points)));
    EXPECT_EQ(refused.code, ErrorCode::kInvalidArtifact);
    EXPECT_NE(refused.message.find("point 17"), std::string::npos);
  }
}

TEST(BuildNdt, OfPointsNeedsNoFile) {
  PassContext ctx;
  const SurfacePoints points = random_points(5, 200000);
  const Result<NdtMap> expected = whole_rows(build_ndt(ctx, {}, points));
  const NoLargeFiles full_disk;
  EXPECT_TRUE(to_bytes(value_of(whole_rows(build_ndt(ctx, {}, points)))) == to_bytes(*expected));
}

}  // namespace
}  // namespace sightline
