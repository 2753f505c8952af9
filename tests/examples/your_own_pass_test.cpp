#include <gtest/gtest.h>

#include <limits>

#include "examples/your_own_pass/clearance.h"
#include "formats/base/random.h"
#include "tests/support/value_of.h"

// Step 4: the three kinds of test that every pass has.

namespace sightline {
namespace {

// A wall cell at (x, y, z) whose normal points along +x.
Nd wall_at(double x_m, double y_m, double z_m) {
  Nd nd;
  nd.mean_m = {x_m, y_m, z_m};
  nd.key = cell_key(nd.mean_m, 2.0);
  nd.point_count = 100;
  nd.covariance_m2 = Eigen::Vector3d(1e-4, 0.3, 0.3).asDiagonal();
  decompose(nd);
  return nd;
}

Sites route(const std::vector<Eigen::Vector3d>& points_m) {
  Sites sites;
  for (const Eigen::Vector3d& p_m : points_m) {
    Site site;
    site.s_m = static_cast<double>(sites.sites.size());
    site.T_map_vehicle.translation() = p_m;
    site.p_map_m = p_m;
    sites.sites.push_back(site);
  }
  return sites;
}

TEST(MeasureClearance, IsTheDistanceToTheNearestWallInReach) {
  NdtMap map;
  map.nds = {wall_at(3.0, 0.0, 0.0), wall_at(-5.0, 0.0, 0.0), wall_at(1.0, 0.0, 4.0)};
  PassContext ctx;
  const SiteColumn table = value_of(measure_clearance(ctx, MeasureClearanceOptions{}, map,
                                                      route({{0.0, 0.0, 0.0}, {0.0, 90.0, 0.0}})));
  EXPECT_DOUBLE_EQ(table.values[0], 3.0) << "the wall overhead does not count";
  EXPECT_EQ(table.values[1], std::numeric_limits<double>::infinity());
}

TEST(MeasureClearance, NeverGrowsWhenAWallIsAdded) {
  Random random(11);
  NdtMap map;
  PassContext ctx;
  const Sites sites = route({{0.0, 0.0, 0.0}, {4.0, 2.0, 0.0}, {-9.0, 5.0, 0.5}});
  std::vector<float> before(3, std::numeric_limits<float>::infinity());
  for (int i = 0; i < 50; ++i) {
    map.nds.push_back(wall_at(random.uniform(-30.0, 30.0), random.uniform(-30.0, 30.0), 0.0));
    const SiteColumn table =
        value_of(measure_clearance(ctx, MeasureClearanceOptions{}, map, sites));
    for (std::size_t s = 0; s < 3; ++s) EXPECT_LE(table.values[s], before[s]);
    before = table.values;
  }
}

TEST(MeasureClearance, RefusesSitesOfAnotherFrame) {
  NdtMap map;
  map.frame.origin_world_m.x() = 64.0;
  PassContext ctx;
  EXPECT_EQ(
      code_of(measure_clearance(ctx, MeasureClearanceOptions{}, map, route({{0.0, 0.0, 0.0}}))),
      ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
