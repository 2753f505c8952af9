#include <gtest/gtest.h>
#include <string>

#include "passes/map/build_surface.h"
#include "passes/rays/cast_rays.h"
#include "tests/support/lane/depth_truth.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

// Depth images in lanes, whose generator shares nothing with the towns that the surface was first
// made for: what is thin, porous or stands free must not shade what lies behind it.

namespace sightline::lane {
namespace {

struct LaneCase {
  std::uint64_t seed = 1;
  int beams = 16;
  bool has_leaves = true;
  double hills = 1.0;
};

std::string name_of(const testing::TestParamInfo<LaneCase>& info) {
  const LaneCase& tried = info.param;
  return "Seed" + std::to_string(tried.seed) + "Beams" + std::to_string(tried.beams) +
         (tried.has_leaves ? "Leaves" : "Bare") + (tried.hills > 0.0 ? "Hills" : "Flat");
}

class DepthFidelity : public testing::TestWithParam<LaneCase> {};

TEST_P(DepthFidelity, ShadesNothingThatLiesBehind) {
  const LaneCase& tried = GetParam();
  constexpr double kLength_m = 60.0;
  const Lane lane = make_lane({tried.seed, kLength_m, tried.has_leaves, tried.hills});
  const Caster caster(lane.mesh);
  DriveOptions drive;
  drive.sensor = value_of(sensor_profile("generic-" + std::to_string(tried.beams)));
  drive.length_m = kLength_m;
  const Surface surface =
      value_of(whole_rows(build_surface(TestContext(), {}, drive_along(lane, caster, drive))));
  const Sites sites = sites_along(lane, kLength_m, 6.0);
  const DepthImages images =
      value_of(cast_rays(TestContext(), {}, surface, sites, SensorProfile()));
  const std::vector<TrueRay> truth = true_rays(lane, caster, sites, images);
  const Fidelity outside_leaves =
      fidelity_of(images, truth, [](const TrueRay& ray) { return !ray.is_through_leaves; });
  EXPECT_LE(outside_leaves.median_m, 0.05);
  EXPECT_LE(outside_leaves.p95_m, 0.5);
  EXPECT_LE(outside_leaves.nearer, 0.04);
  for (double first = -15.0; first < 15.0; first += 5.0) {
    const double last = first == 10.0 ? 15.0 : first + 4.0;
    const Fidelity band = fidelity_of(images, truth, [&](const TrueRay& ray) {
      return ray.elevation_deg > first - 0.5 && ray.elevation_deg < last + 0.5;
    });
    // Between -5 and -1 degrees rays graze hills of which 16 beams saw nothing within 5 m: 0.945.
    const bool is_unseen_ground = first == -5.0 && tried.beams == 16 && tried.hills > 0.0;
    EXPECT_GE(band.agreement, is_unseen_ground ? 0.94 : 0.95) << "from " << first << " degrees";
  }
}

INSTANTIATE_TEST_SUITE_P(Lanes, DepthFidelity,
                         testing::Values(LaneCase{1, 16, true, 1.0}, LaneCase{1, 16, false, 0.0},
                                         LaneCase{2, 64, true, 0.0}, LaneCase{2, 64, false, 1.0}),
                         name_of);

}  // namespace
}  // namespace sightline::lane
