#include "passes/localize/simulate_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "tests/support/box_world.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// A street of boxes as points alone, and places along it.
struct Scene {
  NdtMap map;
  Surface surface;
  Sites sites;
  SensorProfile sensor;
};

// The same street once or more often, each beginning so far along x.
Scene scene_of(const std::vector<double>& begins_m) {
  Scene made;
  PassContext ctx;
  SurfacePoints points;
  const BoxWorld world = random_street(20);
  for (const double begin_m : begins_m) {
    const Eigen::Vector3d off_m = begin_m * Eigen::Vector3d::UnitX();
    for (int i = -5; i < 12; ++i) {
      Pose T_map_lidar = pose_at(i, 0.0, 0.0);
      T_map_lidar.translation().z() = 2.0;
      for (const Eigen::Vector3d& point_m : scan_world(world, T_map_lidar, 1.0).points_m) {
        points.points_m.push_back(T_map_lidar * point_m + off_m);
      }
    }
    for (int i = 0; i < 4; ++i) {
      Site site;
      site.s_m = begin_m + i;
      site.T_map_vehicle = pose_at(begin_m + i, 0.0, 0.3);
      site.T_map_vehicle.translation().z() = 2.0;
      site.p_map_m = site.T_map_vehicle.translation();
      made.sites.sites.push_back(site);
    }
  }
  made.map = *whole_rows(build_ndt(ctx, {}, points));
  made.surface = *whole_rows(build_surface(ctx, {}, points));
  made.sensor = *sensor_profile("generic-16");
  return made;
}

const Scene& scene() {
  static const Scene kScene = scene_of({0.0});
  return kScene;
}

SimulateErrorOptions few_looks() {
  SimulateErrorOptions options;
  options.matching.ranges_m = {10.0, 25.0};
  options.matching.looks = {{.range_m = 25.0, .return_count = 2000, .point_count = 200}};
  options.matching.starts.count = 4;
  return options;
}

Result<ByFamily<MeasuredError>> simulated(const SimulateErrorOptions& options, int threads = 1) {
  const Scene& at = scene();
  return whole_rows(
      simulate_error(TestContext(threads), options, at.surface, at.map, at.sites, at.sensor));
}

ByFamily<MeasuredError> without_times(ByFamily<MeasuredError> measured) {
  visit_families(measured, [](MeasuredError& of_family) {
    for (ErrorRow& row : of_family.rows) {
      row.mean_time_ms = row.max_time_ms = row.tracking_time_ms = 0.0;
    }
  });
  return measured;
}

TEST(SimulateError, FindsEverySiteAgainAndSaysThatNobodyMeasured) {
  const ByFamily<MeasuredError> both = value_of(simulated(few_looks()));
  ASSERT_TRUE(validate(both).has_value());
  const auto& [found, samples] = both;
  EXPECT_EQ(found.reference, ErrorReference::kSimulated);
  EXPECT_EQ(found.drive, "simulated");
  EXPECT_EQ(found.matching.localizer.name, "searching");
  ASSERT_EQ(found.rows.size(), 4U * 2U);
  ASSERT_TRUE(samples.has_value());
  for (std::size_t site = 0; site < 4; ++site) {
    EXPECT_LT(found.row(site, 1).mean_m, 0.1);
    EXPECT_GT(found.row(site, 1).mean_m, 0.0) << "noise and relief are never 0";
    EXPECT_LT(samples->row(site, 0).mean_m, 0.2);
  }
}

TEST(SimulateError, IsTheSameForAnyNumberOfThreads) {
  EXPECT_EQ(to_bytes(without_times(*simulated(few_looks(), 1))),
            to_bytes(without_times(*simulated(few_looks(), 3))));
}

TEST(SimulateError, ErrorsGrowWithTheDisturbance) {
  double before_m = 0.0;
  for (const double noise_m : {0.0, 0.1, 0.4}) {
    SimulateErrorOptions options = few_looks();
    options.range_noise_m = options.relief_m = noise_m;
    const MeasuredError found = value_of(simulated(options)).ranges;
    double sum_m = 0.0;
    for (std::size_t site = 0; site < 4; ++site) sum_m += found.row(site, 1).mean_m;
    EXPECT_GT(sum_m, before_m) << noise_m;
    before_m = sum_m;
  }
}

TEST(SimulateError, HiddenSidesAndMissingReturnsAreMissing) {
  SimulateErrorOptions options = few_looks();
  options.hidden_deg = 0.0;
  options.missing_share = 0.0;
  const std::uint32_t whole = simulated(options)->ranges.row(0, 1).point_count;
  options.hidden_deg = 180.0;
  const std::uint32_t half = simulated(options)->ranges.row(0, 1).point_count;
  EXPECT_LT(half, 0.8 * whole);
  EXPECT_GT(half, 0.2 * whole);
}

TEST(SimulateError, MakesOnlyTheBlocksAnewThatAChangeReaches) {
  Scene both = scene_of({0.0, 512.0});
  KeptParts kept;
  const auto run = [&](PassContext ctx) {
    return to_bytes(without_times(*whole_rows(
        simulate_error(ctx, few_looks(), both.surface, both.map, both.sites, both.sensor))));
  };
  (void)run(kept.context());
  const std::size_t all = kept.made().size();
  EXPECT_EQ(all, kept.count());
  ASSERT_GT(all, 1U);
  const auto farthest =
      std::ranges::max_element(both.map.nds, {}, [](const Nd& nd) { return nd.mean_m.x(); });
  farthest->covariance_m2 *= 1.5;
  decompose(*farthest);
  const std::vector<std::byte> after = run(kept.context());
  EXPECT_GT(kept.made().size(), 0U);
  EXPECT_LT(kept.made().size(), all) << "the first group sees none of it";
  EXPECT_EQ(after, run({}));
  both.surface.patches.front().centre_m.z() += 0.1;
  (void)run(kept.context());
  EXPECT_GT(kept.made().size(), 0U);
  EXPECT_LT(kept.made().size(), all);
}

TEST(SimulateError, RefusesWhatItCannotStandFor) {
  SimulateErrorOptions options = few_looks();
  options.matching.localizer = LocalizerKind::kPclNdt;
  EXPECT_EQ(simulated(options).error().code, ErrorCode::kBadValue);
  Sites elsewhere = scene().sites;
  elsewhere.frame.origin_world_m.x() = 64.0;
  EXPECT_EQ(whole_rows(simulate_error(TestContext(), few_looks(), scene().surface, scene().map,
                                      elsewhere, scene().sensor))
                .error()
                .code,
            ErrorCode::kMismatchedInputs);
}

// A quarter of the view has a quarter of the returns, and which quarter is the vehicle's heading.
TEST(SimulateError, TakesWhatTheSensorSeesOfATurnAlone) {
  SimulateErrorOptions options = few_looks();
  options.hidden_deg = 0.0;
  const auto points_of = [&](double view_deg, double turned_rad) {
    Scene at = scene();
    at.sensor.azimuth_view_deg = view_deg;
    for (Site& site : at.sites.sites) {
      site.T_map_vehicle.rotate(Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitZ()));
    }
    const ByFamily<MeasuredError> found = value_of(whole_rows(
        simulate_error(TestContext(), options, at.surface, at.map, at.sites, at.sensor)));
    return found.ranges.row(0, 1).point_count;
  };
  const std::uint32_t whole = points_of(360.0, 0.0);
  std::uint32_t sum = 0;
  std::set<std::uint32_t> counts;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const std::uint32_t count = points_of(90.0, quarter * std::numbers::pi / 2.0);
    EXPECT_LT(count, 0.7 * whole);
    counts.insert(count);
    sum += count;
  }
  // Voxels at the seams count twice, or with another centroid not at all.
  EXPECT_NEAR(sum, whole, 0.2 * whole);
  EXPECT_GE(counts.size(), 3U);
}

}  // namespace
}  // namespace sightline
