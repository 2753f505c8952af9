#include "passes/factors/virtual/hz_lmin.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

TEST(HzLmin, IsZeroBetweenParallelWallsAndGrowsWithTheFirstCrossWall) {
  const Eigen::Vector2d across(0.0, 1.0);
  const Eigen::Matrix2d walls = 50.0 * across * across.transpose();
  EXPECT_EQ(hz_lmin(walls), 0.0);
  EXPECT_EQ(hz_lmin(walls + 3.0 * Eigen::Vector2d::UnitX() * Eigen::Vector2d::UnitX().transpose()),
            3.0);
}

TEST(HzLmin, IsTheSmallerEigenvalue) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    Eigen::Matrix2d root;
    root << random.normal(), random.normal(), random.normal(), random.normal();
    const Eigen::Matrix2d matrix = root * root.transpose();
    const SymmetricEigen<2> eigen = symmetric_eigen<2>(matrix);
    EXPECT_NEAR(hz_lmin(matrix), eigen.values[0], 1e-12 * matrix.norm());
  }
}

}  // namespace
}  // namespace sightline
