#include "passes/trajectory/local/surface_between.h"

#include <gtest/gtest.h>
#include <vector>

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> level_square(double z_m, double from_x_m = -5.0) {
  std::vector<Eigen::Vector3d> points_m;
  for (double x_m = from_x_m; x_m <= 5.0; x_m += 0.2) {
    for (double y_m = -5.0; y_m <= 5.0; y_m += 0.2) points_m.emplace_back(x_m, y_m, z_m);
  }
  return points_m;
}

TEST(IsSurfaceBetween, FindsTheFloorBetweenTwoStoreys) {
  const Eigen::Vector3d below_m(0.0, 0.0, 1.8);
  const Eigen::Vector3d above_m(2.0, 1.0, 4.55);
  EXPECT_TRUE(is_surface_between(level_square(2.5), below_m, above_m));
  EXPECT_TRUE(is_surface_between(level_square(2.5), above_m, below_m));
  EXPECT_FALSE(is_surface_between(level_square(0.0), below_m, above_m)) << "below both";
  EXPECT_FALSE(is_surface_between(level_square(5.0), below_m, above_m)) << "above both";
  EXPECT_FALSE(is_surface_between(level_square(2.5, 3.0), below_m, above_m)) << "beside them";
}

TEST(IsSurfaceBetween, IgnoresAFewPointsAndWhatIsAtTheSensors) {
  const Eigen::Vector3d below_m(0.0, 0.0, 1.8);
  const Eigen::Vector3d above_m(0.0, 0.0, 3.8);
  std::vector<Eigen::Vector3d> few_m(4, Eigen::Vector3d(0.0, 0.0, 2.8));
  EXPECT_FALSE(is_surface_between(few_m, below_m, above_m));
  few_m.emplace_back(0.0, 0.1, 2.8);
  EXPECT_TRUE(is_surface_between(few_m, below_m, above_m));
  EXPECT_FALSE(is_surface_between(level_square(2.0), below_m, above_m));
  EXPECT_FALSE(is_surface_between({}, below_m, below_m));
}

}  // namespace
}  // namespace sightline
