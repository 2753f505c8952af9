#include <benchmark/benchmark.h>

#include "compiler/base/random.h"
#include "passes/build_ndt.h"

namespace sightline {
namespace {

// Revolutions of a sensor that moves along a street: neighbouring points share cells, and each cell
// is met again by the next scans.
std::vector<Eigen::Vector3d> street_points(std::size_t count) {
  Random random(1);
  std::vector<Eigen::Vector3d> points_m;
  points_m.reserve(count);
  constexpr std::size_t kPerScan = 20000;
  for (std::size_t i = 0; i < count; ++i) {
    const double s_m = static_cast<double>(i / kPerScan);
    const double turn = static_cast<double>(i % kPerScan) / kPerScan;
    const double along_m = s_m + 100.0 * (turn - 0.5);
    const double wall_m = random.below(2) == 0 ? -10.0 : 10.0;
    points_m.emplace_back(along_m, wall_m + 0.02 * random.normal(), random.uniform(-2.0, 12.0));
  }
  return points_m;
}

void build_ndt_one_thread(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  const std::vector<Eigen::Vector3d> points_m = street_points(count);
  for (auto _ : state) {
    const NdtMap map = ndt_from_points(points_m, {}, {}, 1);
    benchmark::DoNotOptimize(map.nds.data());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(build_ndt_one_thread)->Arg(100000)->Arg(3000000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sightline

BENCHMARK_MAIN();
