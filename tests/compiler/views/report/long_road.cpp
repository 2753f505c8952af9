#include "tests/compiler/views/report/long_road.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "formats/base/random.h"
#include "tests/compiler/gate/route_map.h"

namespace sightline {
namespace {

constexpr double kWall_m = 12.0;     // from the middle of the road
constexpr double kWallHigh_m = 8.0;  // over the road
constexpr double kSeen_m = 60.0;     // on both sides, through gaps
constexpr int kNdsOfMetre = 42;      // as in a generated town
constexpr int kPatchesOfMetre = 400;
constexpr std::uint64_t kSeed = 7;

// Where something stands: on the ground, in one of the two walls, or a tree anywhere.
Eigen::Vector3d place_of_something(double from_x_m, Random& random) {
  const double x_m = from_x_m + random.uniform();
  const double kind = random.uniform();
  if (kind < 0.6) return {x_m, random.uniform(-kSeen_m, kSeen_m), 0.05};
  const double high_m = random.uniform(0.0, kWallHigh_m);
  if (kind < 0.9) return {x_m, random.uniform() < 0.5 ? -kWall_m : kWall_m, high_m};
  return {x_m, random.uniform(-kSeen_m, kSeen_m), high_m};
}

void stand_nds(int metres, NdtMap& ndt) {
  Random random(kSeed);
  std::map<std::pair<TileKey, CellKey>, Nd> sorted;
  for (int i = 0; i < metres * kNdsOfMetre; ++i) {
    const int metre = i / kNdsOfMetre;
    Nd nd;
    nd.mean_m = place_of_something(metre, random);
    nd.key = cell_key(nd.mean_m, ndt.cell_m);
    nd.point_count = 10 + static_cast<std::uint32_t>(random.below(1000));
    const bool is_ground = nd.mean_m.z() < 0.1;
    const Eigen::Vector3d deviation_m(random.uniform(0.3, 0.6), is_ground ? 0.4 : 0.05,
                                      is_ground ? 0.02 : random.uniform(0.2, 0.6));
    nd.covariance_m2 = deviation_m.cwiseAbs2().asDiagonal();
    nd.covariance_m2(0, 1) = nd.covariance_m2(1, 0) = random.uniform(-0.01, 0.01);
    decompose(nd);
    sorted[{tile_of(nd.key, ndt.cell_m, ndt.tile_m), nd.key}] = nd;
  }
  ndt.nds.clear();
  for (const auto& [key, nd] : sorted) ndt.nds.push_back(nd);
}

void lay_surface(int metres, Surface& surface) {
  Random random(kSeed);
  surface.patches.clear();
  for (int i = 0; i < metres * kPatchesOfMetre; ++i) {
    const int metre = i / kPatchesOfMetre;
    SurfacePatch patch;
    patch.centre_m = place_of_something(metre, random);
    patch.key = cell_key(patch.centre_m, surface.cell_m);
    patch.half_side_m = surface.cell_m / 2.0;
    surface.patches.push_back(patch);
  }
}

void see(int metres, DepthImages& images) {
  Random random(kSeed);
  images.site_count = static_cast<std::uint32_t>(metres);
  images.distance_m.clear();
  for (int site = 0; site < metres; ++site) {
    for (std::uint32_t row = 0; row < images.elevation_count; ++row) {
      for (std::uint32_t column = 0; column < images.azimuth_count; ++column) {
        const double azimuth = std::numbers::pi / 180.0 * (column + 0.5);
        const double wall_m = kWall_m / std::max(0.05, std::abs(std::sin(azimuth)));
        const bool is_gap =
            (static_cast<std::uint32_t>(site) + column / 6 + row / 8) % 5 == 0 || wall_m > 50.0;
        images.distance_m.push_back(is_gap ? std::numeric_limits<float>::infinity()
                                           : static_cast<float>(wall_m + random.uniform(0.0, 0.3)));
      }
    }
  }
}

}  // namespace

MadeSources long_road(int metres) {
  MadeSources made;
  made.map = route_map(metres);
  made.map.measurement.mapping_drive = "made-up road";
  stand_nds(metres, made.map.ndt);
  for (std::size_t site = 0; site < made.map.sites.sites.size(); ++site) {
    Site& at = made.map.sites.sites[site];
    at.s_m = static_cast<double>(site);
    at.T_map_vehicle = Pose(Eigen::Translation3d(at.p_map_m.x(), 0.0, 0.0));
    const auto range = static_cast<std::uint8_t>(site / 40 % 3);
    set_site(made.map, site, {.range_index = range, .mean_m = 0.04 + 0.01 * range});
  }
  sum_up(made.map);
  made.measured = measured_at(made.map);
  PassContext ctx;
  made.evaluation = *evaluate_ranges(ctx, {}, made.map.sites, made.map.predicted, made.map.ranges,
                                     made.map.factors, made.measured);
  made.trajectory.poses.resize(3);
  made.surface.frame = made.map.ndt.frame;
  made.surface.cell_m = 0.5;
  made.surface.tile_m = made.map.ndt.tile_m;
  lay_surface(metres, made.surface);
  see(metres, made.depth);
  return made;
}

}  // namespace sightline
