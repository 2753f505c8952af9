#include "tests/bench/side_by_side.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "tests/bench/bench_tools.h"

namespace sightline {
namespace {

double cpu_ms(const std::function<void()>& run) {
  const double start_s = cpu_s();
  run();
  return 1e3 * (cpu_s() - start_s);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

void print_heading(const std::string& title) {
  std::printf("\n%-44s %10s %10s %8s %10s %10s\n", title.c_str(), "ours ms", "peer ms", "ratio",
              "ours M/s", "peer M/s");
}

void compare(const SideBySide& work) {
  // Once unmeasured: memory that the process keeps, and files in the page cache.
  work.ours();
  work.peers();
  std::vector<double> ours_ms;
  std::vector<double> peers_ms;
  for (int round = 0; round < work.rounds; ++round) {
    ours_ms.push_back(cpu_ms(work.ours));
    peers_ms.push_back(cpu_ms(work.peers));
  }
  const double ours = median(ours_ms);
  const double peers = median(peers_ms);
  const double items = static_cast<double>(work.items) * 1e-3;  // M/s from ms
  std::printf("%-44s %10.2f %10.2f %8.2f %10.1f %10.1f\n", work.job.c_str(), ours, peers,
              peers / ours, items / ours, items / peers);
  std::fflush(stdout);
}

}  // namespace sightline
