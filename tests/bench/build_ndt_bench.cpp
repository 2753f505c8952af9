#include <cstdio>

#include "passes/build_ndt.h"
#include "passes/matching/match_grid.h"
#include "tests/bench/bench_clouds.h"
#include "tests/bench/pcl_map.h"
#include "tests/bench/side_by_side.h"

// From points to a map that is ready to match, beside PCL's, on one thread. Both take points as they
// keep them in memory.

namespace sightline {
namespace {

std::string job(const char* what, const char* order, double cell_m) {
  return std::string(what) + ", " + order + ", " + std::to_string(static_cast<int>(cell_m)) + " m";
}

BuildNdtOptions with_cell(double cell_m) {
  BuildNdtOptions options;
  options.cell_m = cell_m;
  return options;
}

NdtMap build(const SurfacePoints& points, double cell_m) {
  PassContext ctx;
  ctx.threads = 1;
  Result<NdtMap> map = build_ndt(ctx, with_cell(cell_m), points);
  return map ? std::move(*map) : NdtMap{};
}

void compare_builds(const char* order, const SurfacePoints& points, const PclCloud& cloud) {
  for (const double cell_m : {2.0, 1.0}) {
    compare({job("NDs", order, cell_m), points.points_m.size(), 7,
             [&] { build(points, cell_m); },
             [&] { static_cast<void>(cloud.build_cells(cell_m)); }});
  }
}

void compare_ready(const SurfacePoints& points, const PclCloud& cloud) {
  for (const double cell_m : {2.0, 1.0}) {
    compare({job("ready to match", "scan order", cell_m), points.points_m.size(), 5,
             [&] { make_match_grid(build(points, cell_m)); },
             [&] { cloud.make_ready_to_match(cell_m); }});
  }
}

void compare_all(const BenchClouds& clouds) {
  print_heading(std::string("NDT map of ") + clouds.name);
  SurfacePoints points;
  points.points_m = clouds.map_points_m;
  const PclCloud in_order(points.points_m);
  std::printf("%zu points; NDs of 2 m: ours %zu, PCL's (6 points enough) %zu\n",
              points.points_m.size(), build(points, 2.0).nds.size(), in_order.build_cells(2.0));
  compare_builds("scan order", points, in_order);
  compare_ready(points, in_order);
  points.points_m = shuffled(std::move(points.points_m));
  compare_builds("random order", points, PclCloud(points.points_m));
}

}  // namespace
}  // namespace sightline

int main() {
  sightline::compare_all(sightline::street_clouds());
  if (std::string(sightline::bench_clouds().name) != "drawn street") {
    sightline::compare_all(sightline::bench_clouds());
  }
}
