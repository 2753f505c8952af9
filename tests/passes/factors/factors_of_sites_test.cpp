#include "passes/factors/factors_of_sites.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <map>

#include "passes/factors/compute_factors.h"
#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"
#include "tests/support/toy_world.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

struct Place {
  NdtMap map;
  Surface surface;
  Sites sites;
  SensorProfile sensor;
};

// A street of 150 m: sites in three squares of 64 m, whose order along the street is not that of
// the squares.
Place street() {
  std::string row_of_walls;
  std::string row_of_ground;
  for (int i = 0; i < 150; ++i) {
    row_of_walls += i % 11 < 8 ? '#' : '.';
    row_of_ground += i % 9 == 4 ? '@' : '.';
  }
  const ToyWorld world = draw_world("\n" + row_of_walls + "\n" + row_of_ground + "\n" +
                                    row_of_ground + "\n" + row_of_walls + "\n");
  PassContext ctx;
  Place place;
  place.map = *whole_rows(build_ndt(ctx, {}, world.points));
  place.surface = *whole_rows(build_surface(ctx, {}, world.points));
  place.sites = world.sites;
  std::reverse(place.sites.sites.begin(), place.sites.sites.end());
  for (std::size_t i = 0; i < place.sites.sites.size(); ++i) {
    place.sites.sites[i].s_m = static_cast<double>(i);
  }
  for (int beam = 0; beam < 16; ++beam) {
    place.sensor.beam_elevations_deg.push_back(-15.0 + 2.0 * beam);
  }
  place.sensor.azimuth_step_deg = 1.0;
  return place;
}

FactorTable factors_of(PassContext& ctx, const Place& place) {
  return value_of(
      whole_rows(factors_of_sites(ctx, {}, place.map, place.surface, place.sites, place.sensor)));
}

TEST(FactorsOfSites, AreThoseOfDepthImagesAndVirtualScansOfTheWholeMap) {
  const Place place = street();
  TestContext ctx;
  const DepthImages depth = *cast_rays(ctx, {}, place.surface, place.sites, SensorProfile());
  const VirtualScans scans = *cast_scans(ctx, {}, place.surface, place.sites, place.sensor);
  const FactorWorld world = *make_factor_world(place.map, default_ranges_m());
  const SeenFactors expected = *compute_factors(ctx, world, place.sites, depth, scans);
  ASSERT_GT(expected.unmatched_count, 0U);
  ctx.warnings.clear();
  EXPECT_EQ(to_bytes(factors_of(ctx, place)), to_bytes(expected.table));
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_EQ(ctx.warnings[0], std::to_string(expected.unmatched_count) + " of " +
                                 std::to_string(expected.point_count) +
                                 " virtual points are outside valid NDT cells and are ignored");
}

TEST(FactorsOfSites, AreTheSameForAnyThreadsAndShares) {
  const Place place = street();
  const std::vector<std::byte> expected = to_bytes(factors_of(TestContext(), place));
  std::map<std::size_t, std::vector<std::byte>> parts;
  PassContext ctx;
  ctx.threads = 3;
  ctx.share = {1, 2};
  ctx.part_sink = [&](const PartName& part, std::span<const std::byte> bytes) {
    parts[part.number].assign(bytes.begin(), bytes.end());
  };
  EXPECT_EQ(to_bytes(factors_of(ctx, place)), expected);
  EXPECT_EQ(parts.size(), 3U) << "one for each square";
  ctx.saved_part = [&](const PartName& part) { return std::optional(parts.at(part.number)); };
  ctx.part_sink = [](const PartName&, std::span<const std::byte>) { FAIL() << "made anew"; };
  EXPECT_EQ(to_bytes(factors_of(ctx, place)), expected);
}

TEST(FactorsOfSites, MakeOnlyTheBlocksAnewThatAChangeReaches) {
  Place place = street();
  FactorsOfSitesOptions options;
  options.ranges_m = {5.0, 10.0};
  options.rays.longest_range_m = options.scans.longest_range_m = 10.0;
  KeptParts kept;
  const auto run = [&] {
    PassContext ctx = kept.context();
    return to_bytes(*whole_rows(
        factors_of_sites(ctx, options, place.map, place.surface, place.sites, place.sensor)));
  };
  (void)run();
  ASSERT_EQ(kept.made().size(), 3U);
  const auto nearest =
      std::ranges::min_element(place.map.nds, {}, [](const Nd& nd) { return nd.mean_m.x(); });
  nearest->covariance_m2 *= 1.5;
  decompose(*nearest);
  const std::vector<std::byte> changed = run();
  EXPECT_EQ(kept.made().size(), 1U) << "the square at the beginning of the street";
  EXPECT_EQ(changed,
            to_bytes(*whole_rows(factors_of_sites(TestContext(), options, place.map, place.surface,
                                                  place.sites, place.sensor))));
  place.surface.patches.pop_back();
  (void)run();
  EXPECT_EQ(kept.made().size(), 1U);
  place.sensor.azimuth_step_deg = 2.0;
  (void)run();
  EXPECT_EQ(kept.made().size(), 3U);
}

TEST(FactorsOfSites, RefuseASurfaceOfAnotherFrame) {
  Place place = street();
  place.surface.frame.origin_world_m.x() += 64.0;
  EXPECT_EQ(failure_of(whole_rows(factors_of_sites(TestContext(), {}, place.map, place.surface,
                                                   place.sites, place.sensor)))
                .code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
