#include "passes/weakness/site_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/passes/weakness/corridor.h"

namespace sightline {
namespace {

// The street's walls and ground, by arithmetic: how far each beam should go.
double expected_m(const Eigen::Vector3d& p_m, const Eigen::Vector3d& direction) {
  const double to_wall_m = (kCorridorWall_m - std::abs(p_m.y())) / std::abs(direction.y());
  const double height_m = p_m.z() + to_wall_m * direction.z();
  if (height_m < kCorridorGround_m) return (kCorridorGround_m - p_m.z()) / direction.z();
  return height_m > kCorridorTop_m ? std::numeric_limits<double>::infinity() : to_wall_m;
}

TEST(SiteView, LetsRaysGoAsFarAsTheStreetDoes) {
  const CorridorScene scene;
  const SiteView& view = scene.views.front();
  std::size_t count = 0;
  std::size_t near_count = 0;
  for (std::size_t i = 0; i < scene.directions.size(); ++i) {
    const double true_m = expected_m(view.p_map_m, scene.directions[i]);
    if (!(true_m < 30.0)) continue;
    ++count;
    near_count += std::abs(view.distance_m[i] - true_m) < 0.2 ? 1 : 0;
  }
  EXPECT_GT(count, 5000U);
  EXPECT_GT(static_cast<double>(near_count), 0.95 * static_cast<double>(count));
}

}  // namespace
}  // namespace sightline
