#include <benchmark/benchmark.h>

#include <cmath>

#include "compiler/base/check.h"
#include "compiler/base/random.h"
#include "passes/build_ndt.h"
#include "passes/build_surface.h"
#include "passes/cast_rays.h"
#include "passes/cast_scans.h"
#include "passes/compute_factors.h"

// What it costs to annotate a site: a street 400 m long with walls on both sides, cut by crossings
// every 50 m, and a site every metre of its middle. Time is for one site on one thread.

namespace sightline {
namespace {

constexpr double kHalfLength_m = 200.0;
constexpr double kHalfWidth_m = 9.0;
constexpr int kSites = 128;

SurfacePoints street() {
  Random random(1);
  SurfacePoints points;
  for (int i = 0; i < 4000000; ++i) {
    const double along_m = random.uniform(-kHalfLength_m, kHalfLength_m);
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

// Everything that a site's factors need, made once.
struct Bench {
  PassContext ctx;
  NdtMap map;
  Surface surface;
  Sites sites;
  DepthImages depth;
  VirtualScans scans;

  Bench() {
    const SurfacePoints points = street();
    map = *build_ndt(ctx, {}, points);
    surface = *build_surface(ctx, {}, points);
    for (int i = 0; i < kSites; ++i) {
      Site site;
      site.s_m = i;
      site.p_map_m = {i - 0.5 * kSites, 0.3, 1.8};
      sites.sites.push_back(site);
    }
    depth = *cast_rays(ctx, {}, surface, sites);
    scans = *cast_scans(ctx, {}, surface, sites, sixteen_beams());
  }
};

Bench& bench() {
  static Bench instance;
  return instance;
}

void count_sites(benchmark::State& state) {
  state.counters["per_site"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kSites,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void depth_images(benchmark::State& state) {
  bench();  // made before the clock starts
  for (auto _ : state) {
    SIGHTLINE_CHECK(cast_rays(bench().ctx, {}, bench().surface, bench().sites).has_value());
  }
  count_sites(state);
  state.SetItemsProcessed(state.iterations() * kSites * 360 * 31);  // rays
}
BENCHMARK(depth_images)->Unit(benchmark::kMillisecond);

void virtual_scans(benchmark::State& state) {
  bench();  // made before the clock starts
  const SensorProfile sensor = sixteen_beams();
  for (auto _ : state) {
    SIGHTLINE_CHECK(
        cast_scans(bench().ctx, {}, bench().surface, bench().sites, sensor).has_value());
  }
  count_sites(state);
  state.SetItemsProcessed(state.iterations() * kSites * 16 * 1800);  // rays
}
BENCHMARK(virtual_scans)->Unit(benchmark::kMillisecond);

void all_factors_at_nine_ranges(benchmark::State& state) {
  bench();  // made before the clock starts
  for (auto _ : state) {
    SIGHTLINE_CHECK(
        compute_factors(bench().ctx, {}, bench().map, bench().sites, bench().depth, bench().scans)
            .has_value());
  }
  count_sites(state);
}
BENCHMARK(all_factors_at_nine_ranges)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sightline

BENCHMARK_MAIN();
