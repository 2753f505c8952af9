#include "formats/surroundings/cell_moments.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> random_points(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t i = 0; i < count; ++i) {
    points_m.emplace_back(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                          random.uniform(-1.0, 1.0));
  }
  return points_m;
}

CellMoments moments_of(const std::vector<Eigen::Vector3d>& points_m) {
  CellMoments moments;
  for (const Eigen::Vector3d& point_m : points_m) moments.add(point_m);
  return moments;
}

TEST(CellMoments, GiveTheDistributionOfASmallExample) {
  const CellMoments moments = moments_of({{-0.5, 0.0, 0.25}, {0.5, 0.0, 0.25}, {0.0, 0.75, 0.25}});
  const Nd nd = nd_of({-1, 4, 0}, moments, 2.0);
  EXPECT_EQ(nd.point_count, 3U);
  EXPECT_TRUE(nd.mean_m.isApprox(Eigen::Vector3d(-1.0, 9.25, 1.25), 1e-15));
  EXPECT_NEAR(nd.covariance_m2(0, 0), 0.25, 1e-15);
  EXPECT_NEAR(nd.covariance_m2(1, 1), 0.1875, 1e-15);
  EXPECT_NEAR(nd.covariance_m2(0, 1), 0.0, 1e-15);
  EXPECT_NEAR(nd.eigenvalues_m2[0], 0.25, 1e-15);
}

TEST(CellMoments, AreThoseOfTheOtherPointsWhenSomeAreTakenAwayAgain) {
  const std::vector<Eigen::Vector3d> all_m = random_points(1, 50);
  CellMoments moments = moments_of(all_m);
  for (std::size_t i = 0; i < 20; ++i) moments.add(all_m[i], -1.0);
  const CellMoments rest = moments_of({all_m.begin() + 20, all_m.end()});
  EXPECT_EQ(moments.count, rest.count);
  EXPECT_TRUE(moments.mean_m().isApprox(rest.mean_m(), 1e-12));
  EXPECT_TRUE(moments.covariance_m2().isApprox(rest.covariance_m2(), 1e-12));
}

TEST(CellMoments, AreAddedAndTakenAwayAsTheirPointsAre) {
  const std::vector<Eigen::Vector3d> left_m = random_points(4, 30);
  const std::vector<Eigen::Vector3d> right_m = random_points(5, 70);
  CellMoments moments = moments_of(left_m);
  moments.add(moments_of(right_m));
  moments.add(moments_of(left_m), -1.0);
  const CellMoments rest = moments_of(right_m);
  EXPECT_EQ(moments.count, rest.count);
  EXPECT_TRUE(moments.sum_m.isApprox(rest.sum_m, 1e-12));
  EXPECT_TRUE(moments.products_m2.isApprox(rest.products_m2, 1e-12));
}

TEST(CellMoments, SeenFromAnotherCentreAreThoseOfItsPointsThere) {
  std::vector<Eigen::Vector3d> points_m = random_points(6, 40);
  const Eigen::Vector3d from_there_m(-0.5, 0.5, 0.25);
  const CellMoments there = moments_of(points_m).seen_from(from_there_m);
  for (Eigen::Vector3d& point_m : points_m) point_m += from_there_m;
  const CellMoments expected = moments_of(points_m);
  EXPECT_EQ(there.count, expected.count);
  EXPECT_TRUE(there.sum_m.isApprox(expected.sum_m, 1e-12));
  EXPECT_TRUE(there.products_m2.isApprox(expected.products_m2, 1e-12));
}

TEST(CellMoments, OfTwoDistributionsAreThoseOfAllTheirPoints) {
  const std::vector<Eigen::Vector3d> left_m = random_points(2, 30);
  const std::vector<Eigen::Vector3d> right_m = random_points(3, 70);
  std::vector<Eigen::Vector3d> both_m = left_m;
  both_m.insert(both_m.end(), right_m.begin(), right_m.end());
  CellMoments merged;
  for (const auto& points_m : {left_m, right_m}) {
    const CellMoments part = moments_of(points_m);
    merged.add(nd_of({0, 0, 0}, part, 2.0), part.mean_m());
  }
  const CellMoments whole = moments_of(both_m);
  EXPECT_EQ(merged.count, whole.count);
  EXPECT_TRUE(merged.mean_m().isApprox(whole.mean_m(), 1e-12));
  EXPECT_TRUE(merged.covariance_m2().isApprox(whole.covariance_m2(), 1e-12));
}

}  // namespace
}  // namespace sightline
