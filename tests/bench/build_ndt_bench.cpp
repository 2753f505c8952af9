#include <cstdio>

#include "passes/map/build_ndt.h"
#include "passes/matching/grid/match_grid.h"
#include "tests/bench/bench_clouds.h"
#include "tests/bench/pcl_peers.h"
#include "tests/bench/side_by_side.h"

// From points to a map that is ready to match, beside PCL's, on one thread. Both take points as
// they keep them in memory.

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

using Points = std::vector<Eigen::Vector3d>;

NdtMap build(const Points& points_m, double cell_m) {
  return ndt_from_points(points_m, MapFrame{}, with_cell(cell_m), 1);
}

void compare_builds(const char* order, const Points& points_m, const PclCloud& cloud) {
  for (const double cell_m : {2.0, 1.0}) {
    compare({job("NDs", order, cell_m), points_m.size(), 7, [&] { build(points_m, cell_m); },
             [&] { static_cast<void>(cloud.build_cells(cell_m)); }});
  }
}

void compare_ready(const Points& points_m, const PclCloud& cloud) {
  for (const double cell_m : {2.0, 1.0}) {
    compare({job("ready to match", "scan order", cell_m), points_m.size(), 5,
             [&] { make_match_grid(build(points_m, cell_m)); },
             [&] { cloud.make_ready_to_match(cell_m); }});
  }
}

void compare_all(const BenchClouds& clouds) {
  print_heading(std::string("NDT map of ") + clouds.name);
  Points points_m = clouds.map_points_m;
  const PclCloud in_order(points_m);
  std::printf("%zu points; NDs of 2 m: ours %zu, PCL's (6 points enough) %zu\n", points_m.size(),
              build(points_m, 2.0).nds.size(), in_order.build_cells(2.0));
  compare_builds("scan order", points_m, in_order);
  compare_ready(points_m, in_order);
  points_m = shuffled(std::move(points_m));
  compare_builds("random order", points_m, PclCloud(points_m));
}

}  // namespace
}  // namespace sightline

// The recording where there is one, else the drawn street; with the argument `street` that anyway.
int main(int argc, char** argv) {
  using namespace sightline;
  compare_all(argc > 1 && std::string(argv[1]) == "street" ? street_clouds() : bench_clouds());
}
