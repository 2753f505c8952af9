#include "passes/rays/surface_caster.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "formats/base/random.h"
#include "passes/rays/exact_patch.h"
#include "passes/rays/site_blocks.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Vector3d random_direction(Random& random) {
  const Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
  return direction.normalized();
}

std::vector<Eigen::Vector3d> random_directions(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i) directions.push_back(random_direction(random));
  return directions;
}

Surface empty_surface() {
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  return surface;
}

Surface random_surface(std::uint64_t seed, int count, const Eigen::Vector3d& around_m) {
  Random random(seed);
  Surface surface = empty_surface();
  std::set<CellKey> taken;
  for (int i = 0; i < count; ++i) {
    SurfacePatch patch;
    for (int axis = 0; axis < 3; ++axis) {
      patch.centre_m[axis] = around_m[axis] + random.uniform(-20.0, 20.0);
    }
    patch.key = cell_key(patch.centre_m, surface.cell_m);
    patch.normal = random_direction(random);
    patch.half_side_m = random.uniform(0.2, 0.8);
    if (random.uniform() < 0.5) patch.solid = random.next() | 1;
    // A few squares close together, or none.
    if (random.uniform() < 0.3) patch.solid &= 0x7070700ULL << random.next() % 38;
    if (taken.insert(patch.key).second) surface.patches.push_back(patch);
  }
  return surface;
}

Sites one_site(const Eigen::Vector3d& p_m) {
  Sites sites;
  Site site;
  site.p_map_m = p_m;
  sites.sites.push_back(site);
  return sites;
}

std::vector<double> cast(const Surface& surface, const Eigen::Vector3d& p_m,
                         const std::vector<Eigen::Vector3d>& directions, double near_m,
                         double far_m) {
  std::vector<double> found_m;
  const Result<void> done =
      cast_at_sites(TestContext(), surface, one_site(p_m), {directions, near_m, far_m},
                    [&](std::size_t, std::span<const double> distance_m) {
                      found_m.assign(distance_m.begin(), distance_m.end());
                    });
  EXPECT_TRUE(done.has_value());
  return found_m;
}

// A close call is one that rounding of doubles may decide either way.
struct PlainHit {
  double distance_m = kInfinity;
  bool is_close_call = false;
};

PlainHit plain_cast(const Surface& surface, const Eigen::Vector3d& p_m,
                    const Eigen::Vector3d& direction, double near_m, double far_m) {
  PlainHit hit;
  for (const SurfacePatch& patch : surface.patches) {
    // The ball around the patch is out of the ray's way.
    const Eigen::Vector3d to_centre_m = patch.centre_m - p_m;
    if (to_centre_m.cross(direction).norm() > 1.5 * patch.half_side_m + 1e-3) continue;
    const double slope = patch.normal.dot(direction);
    const double t = patch.normal.dot(to_centre_m) / slope;
    const Eigen::Vector3d off_m = p_m + t * direction - patch.centre_m;
    const Eigen::Vector3d u = side_of(patch);
    const double beyond_m =
        std::max(std::abs(off_m.dot(u)), std::abs(off_m.dot(patch.normal.cross(u)))) -
        patch.half_side_m;
    const bool is_near_limit = std::abs(t - near_m) < 1e-9 || std::abs(t - far_m) < 1e-9;
    if (std::abs(beyond_m) < 1e-9 || std::abs(std::abs(slope) - 0.01) < 1e-9 || is_near_limit) {
      hit.is_close_call = true;
    }
    if (std::abs(slope) < 0.01) continue;
    if (beyond_m > 0.0) continue;
    const double along = off_m.dot(u) / patch.half_side_m;
    const double across = off_m.dot(patch.normal.cross(u)) / patch.half_side_m;
    for (const double place : {4.0 * along, 4.0 * across}) {
      if (std::abs(place - std::round(place)) < 1e-8) hit.is_close_call = true;
    }
    if ((patch.solid >> square_at(along, across) & 1) == 0) continue;
    if (t >= near_m && t <= far_m) hit.distance_m = std::min(hit.distance_m, t);
  }
  return hit;
}

TEST(SurfaceCaster, EqualsAPlainLoopOverPatchesNearAndFarFromTheOrigin) {
  for (const Eigen::Vector3d& p_m :
       {Eigen::Vector3d(1.0, 2.0, 3.0), Eigen::Vector3d(30000.3, -20000.7, 120.0)}) {
    const Surface surface = random_surface(1, 4000, p_m);
    const std::vector<Eigen::Vector3d> directions = random_directions(2, 1003);
    const std::vector<double> found_m = cast(surface, p_m, directions, 0.5, 18.0);
    int compared = 0;
    int hits = 0;
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const PlainHit plain = plain_cast(surface, p_m, directions[i], 0.5, 18.0);
      if (plain.is_close_call) continue;
      ++compared;
      hits += std::isfinite(plain.distance_m) ? 1 : 0;
      if (std::isfinite(plain.distance_m)) {
        EXPECT_NEAR(found_m[i], plain.distance_m, 1e-9);
      } else {
        EXPECT_EQ(found_m[i], kInfinity);
      }
    }
    EXPECT_GT(compared, 1000);
    EXPECT_GT(hits, 100);
  }
}

// Many patches in one plane, edge to edge and overlapping, and rays at their very corners: ties and
// edges without end.
Surface tiled_wall() {
  Surface surface = empty_surface();
  for (int i = 0; i < 4000; ++i) {
    const int layer = i / 2000;
    SurfacePatch patch;
    patch.key = {i % 40, i / 40 % 50, layer};
    patch.centre_m = {30.0 + 1e-6 * (i % 7), 0.5 * (i % 40) - 10.0, 0.5 * (i / 40 % 50) - 12.0};
    patch.normal = Eigen::Vector3d(1.0, 0.0, 1e-5 * (i % 3)).normalized();
    patch.half_side_m = 0.25 + 0.25 * layer;
    surface.patches.push_back(patch);
  }
  return surface;
}

std::vector<Eigen::Vector3d> directions_to_corners() {
  std::vector<Eigen::Vector3d> directions;
  for (int y = -40; y <= 40; ++y) {
    for (int z = -50; z <= 50; ++z) {
      directions.push_back(Eigen::Vector3d(30.0, 0.25 * y, 0.25 * z).normalized());
    }
  }
  return directions;
}

TEST(SurfaceCaster, GivesTheSameBitsWithEveryInstructionSet) {
  const std::vector<Eigen::Vector3d> anywhere = random_directions(5, 50000);
  const Surface surface = random_surface(6, 20000, {10.0, 20.0, 3.0});
  std::vector<std::vector<double>> found_m;
  for (const CasterIsa isa : {CasterIsa::kFastest, CasterIsa::kSse2, CasterIsa::kAvx}) {
    replace_caster_isa(isa);
    found_m.push_back(cast(tiled_wall(), {0.0, 0.0, 0.0}, directions_to_corners(), 0.5, 50.0));
    found_m.push_back(cast(surface, {10.0, 20.0, 3.0}, anywhere, 0.5, 100.0));
  }
  replace_caster_isa(CasterIsa::kFastest);
  for (std::size_t i = 2; i < found_m.size(); ++i) EXPECT_EQ(found_m[i], found_m[i % 2]);
  EXPECT_GT(std::ranges::count(found_m[0], kInfinity), 0);
  EXPECT_LT(std::ranges::count(found_m[0], kInfinity), 4000);
}

TEST(SurfaceCaster, HitsBothFacesAndHonoursNearAndFar) {
  Surface surface = empty_surface();
  surface.patches.push_back({{20, 0, 0}, {10.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.5});
  const std::vector<Eigen::Vector3d> towards = {{1.0, 0.0, 0.0}};
  const std::vector<Eigen::Vector3d> back = {{-1.0, 0.0, 0.0}};
  EXPECT_NEAR(cast(surface, {0.0, 0.0, 0.0}, towards, 0.5, 50.0)[0], 10.0, 1e-12);
  EXPECT_NEAR(cast(surface, {20.0, 0.0, 0.0}, back, 0.5, 50.0)[0], 10.0, 1e-12);
  EXPECT_EQ(cast(surface, {0.0, 0.0, 0.0}, back, 0.5, 50.0)[0], kInfinity);
  EXPECT_EQ(cast(surface, {0.0, 0.0, 0.0}, towards, 0.5, 9.9)[0], kInfinity);
  EXPECT_EQ(cast(surface, {9.8, 0.0, 0.0}, towards, 0.5, 50.0)[0], kInfinity);
}

TEST(SurfaceCaster, GoesOnThroughTheOpenSquaresOfAPatch) {
  Surface surface = empty_surface();
  surface.patches.push_back({{20, 0, 0}, {10.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.5});
  surface.patches.push_back({{22, 0, 0}, {11.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.5});
  const Eigen::Vector3d side = side_of(surface.patches[0]);
  surface.patches[0].solid &= ~(std::uint64_t{1} << square_at(0.1, 0.1));
  const Eigen::Vector3d up = surface.patches[0].normal.cross(side);
  const Eigen::Vector3d open_m = Eigen::Vector3d(10.0, 0.0, 0.0) + 0.05 * side + 0.05 * up;
  const Eigen::Vector3d solid_m = Eigen::Vector3d(10.0, 0.0, 0.0) - 0.05 * side + 0.05 * up;
  const std::vector<double> found_m =
      cast(surface, {0.0, 0.0, 0.0}, {open_m.normalized(), solid_m.normalized()}, 0.5, 50.0);
  EXPECT_NEAR(found_m[0], 1.1 * open_m.norm(), 1e-9);
  EXPECT_NEAR(found_m[1], solid_m.norm(), 1e-9);
}

TEST(SurfaceCaster, CastsOnlyTheRaysThatAreAskedFor) {
  const Surface surface = random_surface(9, 6000, {10.0, 20.0, 3.0});
  Sites sites;  // of several blocks
  for (int i = 0; i < 6; ++i) {
    Site site;
    site.p_map_m = {10.0 + 15.0 * i, 20.0, 3.0};
    sites.sites.push_back(site);
  }
  const RayFan fan{random_directions(10, 1003), 0.5, 60.0};
  const auto found = [&](const RayFan& asked) {
    std::vector<std::vector<double>> found_m(sites.sites.size());
    EXPECT_TRUE(cast_at_sites(TestContext(), surface, sites, asked,
                              [&](std::size_t site, std::span<const double> distance_m) {
                                found_m[site].assign(distance_m.begin(), distance_m.end());
                              }));
    return found_m;
  };
  const std::vector<std::vector<double>> all_m = found(fan);
  const auto is_asked = [](std::size_t site, std::size_t ray) { return (ray / 5 + site) % 3 != 0; };
  RayFan some = fan;
  some.wants = is_asked;
  const std::vector<std::vector<double>> some_m = found(some);
  int hits = 0;
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    for (std::size_t ray = 0; ray < fan.directions.size(); ++ray) {
      hits += std::isfinite(some_m[site][ray]) ? 1 : 0;
      if (is_asked(site, ray)) {
        EXPECT_EQ(some_m[site][ray], all_m[site][ray]);
      } else {
        EXPECT_TRUE(std::isnan(some_m[site][ray]));
      }
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(SurfaceCaster, BoundsHoldWhatIsSolidAndNoMore) {
  Random random(11);
  for (int i = 0; i < 20000; ++i) {
    std::uint64_t solid = random.next();
    for (std::uint64_t fewer = random.next() % 6; fewer > 0; --fewer) solid &= random.next();
    solid |= std::uint64_t{1} << random.next() % 64;
    SolidBounds plain{1.0, -1.0, 1.0, -1.0};
    for (int square = 0; square < 64; ++square) {
      if ((solid >> square & 1) == 0) continue;
      const int column = square % kPatchSquares;
      const int row = square / kPatchSquares;
      const double along = column / 4.0 - 1.0;
      const double across = row / 4.0 - 1.0;
      plain = {std::min(plain.low_along, along), std::max(plain.high_along, along + 0.25),
               std::min(plain.low_across, across), std::max(plain.high_across, across + 0.25)};
    }
    const SolidBounds bounds = bounds_of_solid(solid);
    ASSERT_EQ(bounds.low_along, plain.low_along);
    ASSERT_EQ(bounds.high_along, plain.high_along);
    ASSERT_EQ(bounds.low_across, plain.low_across);
    ASSERT_EQ(bounds.high_across, plain.high_across);
  }
}

TEST(SurfaceCaster, SeesNothingWhereThereIsNoSurface) {
  const std::vector<Eigen::Vector3d> directions = {{1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}};
  EXPECT_EQ(cast(empty_surface(), {1.0, 1.0, 1.0}, directions, 0.0, 50.0),
            (std::vector<double>{kInfinity, kInfinity}));
}

TEST(SurfaceCaster, GivesABlockEveryPatchThatItsSitesCanReach) {
  const Surface surface = random_surface(3, 2000, {60.0, 60.0, 0.0});
  Random random(4);
  Sites sites;
  for (int i = 0; i < 40; ++i) {
    Site site;
    site.p_map_m = {random.uniform(0.0, 130.0), random.uniform(0.0, 130.0), 1.0};
    sites.sites.push_back(site);
  }
  const TiledSurface tiled = surface;
  const double reach_m = 15.0 + std::numbers::sqrt2 * tiled.reach_m();
  std::set<std::size_t> seen;
  for (const SiteBlock& block : blocks_of_sites(sites)) {
    std::set<SurfaceOrder> near;
    for (const SurfacePatch& patch :
         patches_near(block, *tiled.over(box_around(block, reach_m)), reach_m)) {
      near.insert(order_of(patch, surface));
    }
    for (const std::size_t site : block.sites) {
      EXPECT_TRUE(seen.insert(site).second);
      for (const SurfacePatch& patch : surface.patches) {
        const double apart_m = (patch.centre_m - sites.sites[site].p_map_m).norm();
        const bool is_in_reach = apart_m <= 15.0 + std::numbers::sqrt2 * patch.half_side_m;
        EXPECT_TRUE(!is_in_reach || near.contains(order_of(patch, surface)));
      }
    }
    EXPECT_LT(near.size(), surface.patches.size());
  }
  EXPECT_EQ(seen.size(), sites.sites.size());
}

TEST(SurfaceCaster, MeetsPatchesWhereAChangePutThem) {
  // Out of reach until they are moved by ten metres, and in reach until then.
  Surface surface = random_surface(7, 4000, {82.0, 20.0, 2.0});
  surface.tile_m = 8.0;
  const auto move = [](SurfacePatch& patch) { patch.centre_m.x() -= 10.0; };
  Surface moved = surface;
  for (SurfacePatch& patch : moved.patches) {
    move(patch);
    patch.key = cell_key(patch.centre_m, moved.cell_m);
  }
  const RayFan fan{random_directions(8, 2000), 0.5, 12.0};
  const Sites sites = one_site({62.0, 20.0, 2.0});
  const SiteCaster caster(surface, sites, fan.far_m, move);
  std::vector<double> found_m;
  const BlockScene scene = value_of(caster.scene(caster.blocks().front()));
  scene.cast(fan, 1, [&](std::size_t, std::span<const double> distance_m) {
    found_m.assign(distance_m.begin(), distance_m.end());
  });
  EXPECT_EQ(found_m, cast(moved, sites.sites.front().p_map_m, fan.directions, 0.5, 12.0));
  EXPECT_GT(std::ranges::count_if(found_m, [](double m) { return std::isfinite(m); }), 20);
}

Surface retiled(Surface surface, double tile_m) {
  surface.tile_m = tile_m;
  std::sort(surface.patches.begin(), surface.patches.end(),
            [&](const SurfacePatch& a, const SurfacePatch& b) {
              return std::pair(tile_of(a.key, surface.cell_m, tile_m), a.key) <
                     std::pair(tile_of(b.key, surface.cell_m, tile_m), b.key);
            });
  return surface;
}

TEST(SurfaceCaster, GivesTheSameDistancesForAnyTiling) {
  const Surface surface = random_surface(5, 6000, {30.0, -20.0, 2.0});
  const std::vector<Eigen::Vector3d> directions = random_directions(6, 4000);
  const Eigen::Vector3d p_m(31.0, -22.0, 2.5);
  const std::vector<double> found_m = cast(retiled(surface, 64.0), p_m, directions, 0.5, 50.0);
  EXPECT_EQ(found_m, cast(retiled(surface, 32.0), p_m, directions, 0.5, 50.0));
  EXPECT_EQ(found_m, cast(retiled(surface, 16.0), p_m, directions, 0.5, 50.0));
}

}  // namespace
}  // namespace sightline
