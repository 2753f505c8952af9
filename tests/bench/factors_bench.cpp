#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <memory>

#include "formats/base/check.h"
#include "formats/base/random.h"
#include "passes/factors/compute_factors.h"
#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "passes/pass/default_looks.h"
#include "passes/rays/cast_rays.h"
#include "passes/rays/cast_scans.h"
#include "tests/support/value_of.h"
#include "tests/support/whole_rows.h"

// What it costs to annotate a site: a street with walls on both sides, cut by crossings every 50 m,
// and a site every metre of its middle. Time is for one site on one thread. The argument is the
// street's length in metres: ten times the map and ten times the sites cost the same a site.

namespace sightline {
namespace {

constexpr double kHalfWidth_m = 9.0;
constexpr int kPointsPerMetre = 10000;
// The ends of the street see less than its middle.
constexpr int kWithoutSites_m = 60;

SurfacePoints street(int length_m) {
  Random random(1);
  SurfacePoints points;
  for (int i = 0; i < kPointsPerMetre * length_m; ++i) {
    const double along_m = random.uniform(0.0, length_m);
    const bool is_crossing = along_m - 50.0 * std::floor(along_m / 50.0) < 8.0;
    if (i % 3 == 0) {
      points.points_m.emplace_back(along_m, random.uniform(-60.0, 60.0), 0.02 * random.normal());
    } else if (!is_crossing) {
      const double wall_m = i % 2 == 0 ? -kHalfWidth_m : kHalfWidth_m;
      points.points_m.emplace_back(along_m, wall_m + 0.3 * std::floor(2.0 * random.uniform()),
                                   random.uniform(0.0, 12.0));
    }
  }
  return points;
}

SensorProfile sixteen_beams() {
  SensorProfile sensor;
  for (int beam = 0; beam < 16; ++beam) sensor.beam_elevations_deg.push_back(-15.0 + 2.0 * beam);
  return sensor;
}

struct Bench {
  PassContext ctx;
  NdtMap map;
  Surface surface;
  Sites sites;
  DepthImages depth;
  VirtualScans scans;

  explicit Bench(int length_m) {
    ctx.threads = 1;
    const SurfacePoints points = street(length_m);
    map = *whole_rows(build_ndt(ctx, {}, points));
    surface = *whole_rows(build_surface(ctx, {}, points));
    for (int i = kWithoutSites_m; i < length_m - kWithoutSites_m; ++i) {
      Site site;
      site.s_m = i;
      site.p_map_m = {static_cast<double>(i), 0.3, 1.8};
      sites.sites.push_back(site);
    }
    depth = *cast_rays(ctx, {}, surface, sites, SensorProfile());
    scans = *cast_scans(ctx, {}, surface, sites, sixteen_beams());
  }
};

Bench& bench(const benchmark::State& state) {
  static std::map<std::int64_t, std::unique_ptr<Bench>> made;
  std::unique_ptr<Bench>& one = made[state.range(0)];
  if (one == nullptr) one = std::make_unique<Bench>(static_cast<int>(state.range(0)));
  return *one;
}

void count_sites(const Bench& made, benchmark::State& state) {
  const auto sites = static_cast<double>(made.sites.sites.size());
  state.counters["per_site"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * sites,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void depth_images(benchmark::State& state) {
  Bench& made = bench(state);  // before the clock starts
  for (auto _ : state) {
    SIGHTLINE_CHECK(cast_rays(made.ctx, {}, made.surface, made.sites, SensorProfile()).has_value());
  }
  count_sites(made, state);
  state.SetItemsProcessed(state.iterations() *
                          static_cast<std::int64_t>(made.depth.distance_m.size()));
}
BENCHMARK(depth_images)->Arg(250)->Arg(2500)->Unit(benchmark::kMillisecond);

void virtual_scans(benchmark::State& state) {
  Bench& made = bench(state);  // before the clock starts
  const SensorProfile sensor = sixteen_beams();
  for (auto _ : state) {
    SIGHTLINE_CHECK(cast_scans(made.ctx, {}, made.surface, made.sites, sensor).has_value());
  }
  count_sites(made, state);
  const auto rays = static_cast<std::int64_t>(made.sites.sites.size()) * 16 * 1800;
  state.SetItemsProcessed(state.iterations() * rays);
}
BENCHMARK(virtual_scans)->Arg(250)->Arg(2500)->Unit(benchmark::kMillisecond);

void all_factors_at_nine_ranges(benchmark::State& state) {
  Bench& made = bench(state);  // before the clock starts
  for (auto _ : state) {
    const FactorWorld world = value_of(make_factor_world(made.map, default_ranges_m()));
    SIGHTLINE_CHECK(
        compute_factors(made.ctx, world, made.sites, made.depth, made.scans).has_value());
  }
  count_sites(made, state);
}
BENCHMARK(all_factors_at_nine_ranges)->Arg(250)->Arg(2500)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sightline

BENCHMARK_MAIN();
