// Depth images of the product against the exact triangles of lanes (tests/support/lane), with and
// without leaves: `depth_bench [--beams 16 64] [--seeds 1 2] [--length-m 60]`. Overall, by bands of
// elevation, by what is truly hit, and what the surface costs. "Nearer" and "farther": shares of
// rays that are found more than 0.5 m off that way, a miss counting as far.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <string>

#include "formats/base/check.h"
#include "passes/map/build_surface.h"
#include "passes/map/remove_moving.h"
#include "passes/rays/cast_rays.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/lane/depth_truth.h"
#include "tests/support/value_of.h"
#include "tests/support/whole_rows.h"

namespace sightline::lane {
namespace {

struct BenchOptions {
  std::vector<int> beams = {16};
  std::vector<std::uint64_t> seeds = {1};
  double length_m = 60.0;
  double site_spacing_m = 3.0;
  double hills = 1.0;
  int threads = 1;
  bool prints_rows = false;
};

void print(const std::string& name, const Fidelity& fit) {
  std::printf("%-22s %9zu %8.2f %9.1f %8.1f %8.2f %8.2f\n", name.c_str(), fit.rays,
              100.0 * fit.agreement, 100.0 * fit.median_m, 100.0 * fit.p95_m, 100.0 * fit.nearer,
              100.0 * fit.farther);
}

void print_tables(const DepthImages& images, const std::vector<TrueRay>& truth,
                  const BenchOptions& options) {
  std::printf("%-22s %9s %8s %9s %8s %8s %8s\n", "", "rays", "agree %", "median cm", "p95 cm",
              "nearer %", "farther %");
  const auto add = [&](const std::string& name, const auto& counts) {
    print(name, fidelity_of(images, truth, counts));
  };
  add("all", [](const TrueRay&) { return true; });
  add("hits no leaf", [](const TrueRay& ray) { return !is_foliage(ray.kind); });
  add("comes near no leaf", [](const TrueRay& ray) { return !ray.is_through_leaves; });
  for (double first = -15.0; first < 15.0; first += 5.0) {
    const double last = first == 10.0 ? 15.0 : first + 4.0;
    add(std::to_string(static_cast<int>(first)) + " .. " + std::to_string(static_cast<int>(last)),
        [&](const TrueRay& ray) {
          return ray.elevation_deg > first - 0.5 && ray.elevation_deg < last + 0.5;
        });
  }
  for (std::uint32_t row = 0; row < images.elevation_count; ++row) {
    const double at = images.first_elevation_deg + row * images.elevation_step_deg;
    if (!options.prints_rows && std::abs(at) > 1.1) continue;
    add("at " + std::to_string(static_cast<int>(at)),
        [&](const TrueRay& ray) { return std::abs(ray.elevation_deg - at) < 0.1; });
  }
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    add(std::string(kKindNames[kind]), [&](const TrueRay& ray) {
      return std::isfinite(ray.range_m) && ray.kind == static_cast<Kind>(kind);
    });
  }
  add("nothing", [](const TrueRay& ray) { return !std::isfinite(ray.range_m); });
}

void measure(std::uint64_t seed, bool has_leaves, int beams, const BenchOptions& options) {
  const Lane lane = make_lane({seed, options.length_m, has_leaves, options.hills});
  const Caster caster(lane.mesh);
  const SensorProfile sensor = value_of(sensor_profile("generic-" + std::to_string(beams)));
  DriveOptions drive;
  drive.sensor = sensor;
  drive.length_m = options.length_m;
  drive.threads = options.threads;
  const SurfacePoints points = drive_along(lane, caster, drive);
  PassContext ctx;
  ctx.threads = options.threads;
  const double begin_s = cpu_s();
  const Result<Surface> surface = whole_rows(build_surface(ctx, {}, points));
  const double built_s = cpu_s();
  SIGHTLINE_CHECK(surface);
  const Sites sites = sites_along(lane, options.length_m, options.site_spacing_m);
  const Result<DepthImages> images = cast_rays(ctx, {}, *surface, sites, SensorProfile());
  const double cast_s = cpu_s();
  SIGHTLINE_CHECK(images);
  std::printf(
      "\nlane %llu, %s, %d beams: %llu points, %zu patches, surface %.2f s, %.2f ms a site\n",
      static_cast<unsigned long long>(seed), has_leaves ? "leaves" : "no leaves", beams,
      static_cast<unsigned long long>(points.standing_count), surface->patches.size(),
      built_s - begin_s, 1e3 * (cast_s - built_s) / static_cast<double>(sites.sites.size()));
  print_tables(*images, true_rays(lane, caster, sites, *images), options);
}

}  // namespace
}  // namespace sightline::lane

int main(int argc, char** argv) {
  using namespace sightline::lane;
  BenchOptions options;
  CLI::App app("Depth images against exact triangles");
  app.add_option("--beams", options.beams);
  app.add_option("--seeds", options.seeds);
  app.add_option("--length-m", options.length_m);
  app.add_option("--site-spacing-m", options.site_spacing_m);
  app.add_option("--hills", options.hills);
  app.add_option("--threads", options.threads);
  app.add_flag("--rows", options.prints_rows);
  CLI11_PARSE(app, argc, argv);
  for (const std::uint64_t seed : options.seeds) {
    for (const int beams : options.beams) {
      for (const bool has_leaves : {true, false}) measure(seed, has_leaves, beams, options);
    }
  }
  return 0;
}
