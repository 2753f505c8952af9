#include <benchmark/benchmark.h>

#include <cstdio>
#include <string>

#include "passes/matching/scan_preparation.h"
#include "tests/bench/bench_clouds.h"
#include "tests/bench/pcl_peers.h"
#include "tests/bench/side_by_side.h"

// Voxel subsampling beside pcl::VoxelGrid on one thread: a dense map, a scan, and streets of a city
// with hardly more than one point to a voxel.

namespace sightline {
namespace {

void compare_leaves(const char* what, const std::vector<Eigen::Vector3d>& points_m, int rounds,
                    int repeats) {
  const PclCloud cloud(points_m);
  for (const double leaf_m : {0.2, 0.5, 1.0}) {
    if (cloud.subsample(leaf_m) == points_m.size()) continue;  // too many voxels for PCL's index
    char job[80];
    std::snprintf(job, sizeof job, "%s, leaf %.1f m, %zu voxels", what, leaf_m,
                  voxel_subsample(points_m, leaf_m).size());
    const auto repeat = [&](const auto& run) {
      for (int i = 0; i < repeats; ++i) run();
    };
    compare({job, points_m.size() * static_cast<std::size_t>(repeats), rounds,
             [&] { repeat([&] { benchmark::DoNotOptimize(voxel_subsample(points_m, leaf_m)); }); },
             [&] { repeat([&] { benchmark::DoNotOptimize(cloud.subsample(leaf_m)); }); }});
  }
}

void compare_all(const BenchClouds& clouds) {
  print_heading(std::string("Voxels of ") + clouds.name);
  compare_leaves("scan", clouds.scan_points_m, 15, 10);
  compare_leaves("dense map", clouds.map_points_m, 5, 1);
}

}  // namespace
}  // namespace sightline

int main() {
  using namespace sightline;
  print_heading("Voxels of a drawn city");
  compare_leaves("sparse map", sparse_city_points(), 7, 1);
  compare_all(street_clouds());
  if (std::string(bench_clouds().name) != "drawn street") compare_all(bench_clouds());
}
