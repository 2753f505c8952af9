#include "formats/surroundings/ndt_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "formats/base/random.h"
#include "formats/symmetric_eigen.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/toy_world.h"

namespace sightline {
namespace {

Nd nd_with_sigmas(double sigma1_m, double sigma2_m, double sigma3_m) {
  Nd nd;
  nd.eigenvalues_m2 = {sigma1_m * sigma1_m, sigma2_m * sigma2_m, sigma3_m * sigma3_m};
  return nd;
}

TEST(NdtMap, SurvivesDisk) {
  NdtMap map = random_ndt_map(1, 4, 6.0);
  map.frame.origin_world_m = {640.0, -128.0, 64.0};
  map.sparse_cell_count = 7;
  expect_survives_disk(map);
}

TEST(NdtMap, GivesTheSameEigenvectorsToTheBitAfterDisk) {
  const NdtMap map = random_ndt_map(2, 50, 30.0);
  const Result<NdtMap> back = from_bytes<NdtMap>(to_bytes(map));
  ASSERT_TRUE(back.has_value());
  for (std::size_t i = 0; i < map.nds.size(); ++i) {
    EXPECT_EQ(map.nds[i].eigenvectors, back->nds[i].eigenvectors);
    EXPECT_EQ(map.nds[i].eigenvalues_m2, back->nds[i].eigenvalues_m2);
  }
}

TEST(NdtMap, PutsAPointOnALowerFaceIntoTheCellAboveIt) {
  EXPECT_EQ(cell_key({2.0, -2.0, 0.0}, 2.0), (CellKey{1, -1, 0}));
  EXPECT_EQ(cell_key({1.9999999, -2.0000001, -1e-12}, 2.0), (CellKey{0, -2, -1}));
}

TEST(NdtMap, FloorsLikeTheLibraryForAnyNumber) {
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const double value = random.uniform(-100.0, 100.0) * std::pow(10.0, random.uniform(-9.0, 6.0));
    ASSERT_EQ(floor_to_int(value), static_cast<std::int32_t>(std::floor(value))) << value;
  }
}

TEST(NdtMap, CountsTilesBelowZeroDownwards) {
  EXPECT_EQ(tile_of({0, 31, 5}, 2.0, 64.0), (TileKey{0, 0}));
  EXPECT_EQ(tile_of({32, -1, 5}, 2.0, 64.0), (TileKey{1, -1}));
  EXPECT_EQ(tile_of({-32, -33, 5}, 2.0, 64.0), (TileKey{-1, -2}));
}

TEST(NdtMap, OnlyWholeCellsMakeATile) {
  EXPECT_TRUE(is_tiling(2.0, 64.0));
  EXPECT_TRUE(is_tiling(0.1, 64.0));
  EXPECT_FALSE(is_tiling(3.0, 64.0));
  EXPECT_FALSE(is_tiling(64.0, 2.0));
  EXPECT_FALSE(is_tiling(0.0, 64.0));
}

TEST(NdtMap, ClassifiesByTheLargestOfEquationOneAndTheFirstOnATie) {
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.1, 0.05)), 1);
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.9, 0.05)), 2);
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.9, 0.8)), 3);
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 0.5, 0.0)), 1);    // linear equals planar
  EXPECT_EQ(dimension_class(nd_with_sigmas(1.0, 1.0, 0.5)), 2);    // planar equals round
  EXPECT_EQ(dimension_class(nd_with_sigmas(0.75, 0.5, 0.25)), 1);  // all three equal
}

TEST(NdtMap, RegularisationRaisesSmallEigenvaluesAndKeepsTheRest) {
  Random random(4);
  for (const Nd& nd : random_ndt_map(5, 100, 40.0).nds) {
    const Eigen::Matrix3d regularised = regularised_covariance_m2(nd);
    const SymmetricEigen<3> eigen = symmetric_eigen<3>(regularised);
    for (int i = 0; i < 3; ++i) {
      const double expected = std::max(nd.eigenvalues_m2[i], 0.01 * nd.eigenvalues_m2[0]);
      EXPECT_NEAR(eigen.values[2 - i], expected, 1e-12 * nd.eigenvalues_m2[0]);
      const Eigen::Vector3d scaled = expected * nd.eigenvectors.col(i);
      EXPECT_TRUE((regularised * nd.eigenvectors.col(i)).isApprox(scaled, 1e-9));
    }
    EXPECT_EQ(regularised, regularised.transpose());
  }
}

TEST(NdtMap, RefusesAMeanOutsideItsCell) {
  NdtMap map = random_ndt_map(6, 20, 20.0);
  map.nds[3].mean_m.x() += 2.0;
  const Result<void> valid = validate(map);
  ASSERT_FALSE(valid.has_value());
  EXPECT_EQ(valid.error().place, "nd 3");
}

TEST(NdtMap, RefusesCellsOutOfOrder) {
  NdtMap map = random_ndt_map(7, 20, 20.0);
  std::swap(map.nds[4], map.nds[5]);
  EXPECT_FALSE(validate(map).has_value());
  map = random_ndt_map(7, 20, 20.0);
  map.nds[5] = map.nds[4];
  EXPECT_FALSE(validate(map).has_value());
}

TEST(NdtMap, RefusesNumbersThatAreNotFinite) {
  NdtMap map = random_ndt_map(8, 5, 20.0);
  map.nds[0].covariance_m2(0, 1) = std::nan("");
  EXPECT_FALSE(validate(map).has_value());
  map = random_ndt_map(8, 5, 20.0);
  map.nds[0].mean_m.z() = 1e300;
  EXPECT_FALSE(validate(map).has_value());
}

}  // namespace
}  // namespace sightline
