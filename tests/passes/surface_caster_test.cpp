#include "passes/surface_caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "compiler/base/random.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Vector3d random_direction(Random& random) {
  const Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
  return direction.normalized();
}

// `count` discs around a place, no two in one cell.
Surface random_surface(std::uint64_t seed, int count, const Eigen::Vector3d& around_m) {
  Random random(seed);
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  std::set<CellKey> taken;
  for (int i = 0; i < count; ++i) {
    SurfaceDisc disc;
    for (int axis = 0; axis < 3; ++axis) {
      disc.centre_m[axis] = around_m[axis] + random.uniform(-20.0, 20.0);
    }
    disc.key = cell_key(disc.centre_m, surface.cell_m);
    disc.normal = random_direction(random);
    disc.radius_m = random.uniform(0.2, 0.8);
    if (taken.insert(disc.key).second) surface.discs.push_back(disc);
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
                         const Directions& directions, double near_m, double far_m) {
  const std::vector<SiteBlock> blocks = blocks_of_sites(one_site(p_m), surface, far_m);
  const SurfaceCaster caster(surface, blocks.at(0));
  std::vector<double> distance_m(directions.size());
  caster.cast(p_m, directions, near_m, far_m, distance_m);
  return distance_m;
}

// How near the ray passes to the rim of a disc that it may or may not hit: there float decides.
struct PlainHit {
  double distance_m = kInfinity;
  bool is_close_call = false;
};

PlainHit plain_cast(const Surface& surface, const Eigen::Vector3d& p_m,
                    const Eigen::Vector3d& direction, double near_m, double far_m) {
  PlainHit hit;
  for (const SurfaceDisc& disc : surface.discs) {
    // The ball around the disc is out of the ray's way.
    const Eigen::Vector3d to_centre_m = disc.centre_m - p_m;
    if (to_centre_m.cross(direction).norm() > disc.radius_m + 1e-3) continue;
    const double slope = disc.normal.dot(direction);
    const double t = disc.normal.dot(to_centre_m) / slope;
    const double off_m = (p_m + t * direction - disc.centre_m).norm() - disc.radius_m;
    const bool is_near_limit = std::abs(t - near_m) < 1e-3 || std::abs(t - far_m) < 1e-3;
    if (std::abs(off_m) < 1e-3 || std::abs(slope) < 1e-3 || is_near_limit) {
      hit.is_close_call = true;
    }
    if (off_m <= 0.0 && t >= near_m && t <= far_m) hit.distance_m = std::min(hit.distance_m, t);
  }
  return hit;
}

TEST(SurfaceCaster, EqualsAPlainLoopOverDiscsNearAndFarFromTheOrigin) {
  for (const Eigen::Vector3d& p_m :
       {Eigen::Vector3d(1.0, 2.0, 3.0), Eigen::Vector3d(30000.3, -20000.7, 120.0)}) {
    const Surface surface = random_surface(1, 4000, p_m);
    Random random(2);
    Directions directions;
    for (int i = 0; i < 1003; ++i) directions.push_back(random_direction(random));
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
    EXPECT_GT(compared, 600);
    EXPECT_GT(hits, 100);
  }
}

TEST(SurfaceCaster, HitsBothFacesAndHonoursNearAndFar) {
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  surface.discs.push_back({{20, 0, 0}, {10.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.5});
  const Directions towards = {{1.0, 0.0, 0.0}};
  const Directions back = {{-1.0, 0.0, 0.0}};
  EXPECT_NEAR(cast(surface, {0.0, 0.0, 0.0}, towards, 0.5, 50.0)[0], 10.0, 1e-12);
  EXPECT_NEAR(cast(surface, {20.0, 0.0, 0.0}, back, 0.5, 50.0)[0], 10.0, 1e-12);
  EXPECT_EQ(cast(surface, {0.0, 0.0, 0.0}, back, 0.5, 50.0)[0], kInfinity);
  EXPECT_EQ(cast(surface, {0.0, 0.0, 0.0}, towards, 0.5, 9.9)[0], kInfinity);
  EXPECT_EQ(cast(surface, {9.8, 0.0, 0.0}, towards, 0.5, 50.0)[0], kInfinity);
}

TEST(SurfaceCaster, SeesNothingWhereThereIsNoSurface) {
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  const Directions directions = {{1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}};
  EXPECT_EQ(cast(surface, {1.0, 1.0, 1.0}, directions, 0.0, 50.0),
            (std::vector<double>{kInfinity, kInfinity}));
}

TEST(SurfaceCaster, GivesABlockEveryDiscThatItsSitesCanReach) {
  const Surface surface = random_surface(3, 2000, {60.0, 60.0, 0.0});
  Random random(4);
  Sites sites;
  for (int i = 0; i < 40; ++i) {
    Site site;
    site.p_map_m = {random.uniform(0.0, 130.0), random.uniform(0.0, 130.0), 1.0};
    sites.sites.push_back(site);
  }
  std::set<std::size_t> seen;
  for (const SiteBlock& block : blocks_of_sites(sites, surface, 15.0)) {
    const std::set<std::uint32_t> discs(block.discs.begin(), block.discs.end());
    EXPECT_TRUE(std::is_sorted(block.discs.begin(), block.discs.end(),
                               [&](std::uint32_t a, std::uint32_t b) {
                                 return surface.discs[a].key < surface.discs[b].key;
                               }));
    for (const std::size_t site : block.sites) {
      EXPECT_TRUE(seen.insert(site).second);
      for (std::uint32_t i = 0; i < surface.discs.size(); ++i) {
        const double apart_m = (surface.discs[i].centre_m - sites.sites[site].p_map_m).norm();
        const bool is_in_reach = apart_m <= 15.0 + surface.discs[i].radius_m;
        EXPECT_TRUE(!is_in_reach || discs.contains(i));
      }
    }
  }
  EXPECT_EQ(seen.size(), sites.sites.size());
}

}  // namespace
}  // namespace sightline
