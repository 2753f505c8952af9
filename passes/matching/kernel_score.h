#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "passes/matching/grid/match_grid.h"
#include "passes/matching/match_score.h"

namespace sightline {

// Which version of the inner loop computes the score. All but kExact give the same bits.
enum class MatchKernel : std::uint8_t {
  kFastest,   // of those below that this processor has
  kPortable,  // in float with fused multiply-adds
  kAvx2,
  kAvx512,
  kExact  // match_score(), in double: the oracle of the others
};
bool is_supported(MatchKernel kernel);
MatchKernel fastest_kernel();
std::string_view kernel_name(MatchKernel kernel);  // "avx2"

// For tests: from here on kFastest is this supported version in the whole process; kFastest undoes
// it.
void replace_fastest_kernel(MatchKernel kernel);
// For benchmarks: a version that is defined elsewhere and must outlive its use; null undoes it.
void replace_fastest_kernel(const KernelVersion* version);

// Points of one scan as the kernels read them, and what one evaluation remembers for the next: the
// cell of each point, good for every grid of the same cells. Use it from one thread at a time.
struct ScanForMatch {
  std::vector<Eigen::Vector3d> points_m;
  std::size_t thin_count = 0;         // so many leading points are spread over the whole scan
  double farthest_m = 0.0;            // distance of the farthest point
  std::vector<double> x_m, y_m, z_m;  // padded with zeros to whole batches
  std::vector<double> cell_x, cell_y, cell_z;
  std::vector<std::int32_t> record;
  std::uint64_t cells_digest = 0;  // of the grid that knows these cells
};
// Every `thin_stride`-th point goes first, else the order is kept. thin_stride >= 1.
ScanForMatch make_scan_for_match(std::span<const Eigen::Vector3d> points_m,
                                 std::size_t thin_stride = 1);
// The same into the memory of a scan that is done with.
void fill_scan_for_match(std::span<const Eigen::Vector3d> points_m, std::size_t thin_stride,
                         ScanForMatch& scan);

// match_score() in float of the first `count` points, which are all or a multiple of 16: sums agree
// to about 1e-6 of the sum of sizes. Any kernel that is_supported. Allocates nothing.
MatchScore kernel_score(const MatchGrid& grid, ScanForMatch& scan, std::size_t count,
                        const Pose& T_map_sensor, MatchKernel kernel);
// Its score alone, to the bit, for less than half of the time.
double kernel_score_alone(const MatchGrid& grid, ScanForMatch& scan, std::size_t count,
                          const Pose& T_map_sensor, MatchKernel kernel);
inline MatchScore kernel_score(const MatchGrid& grid, ScanForMatch& scan, const Pose& T_map_sensor,
                               MatchKernel kernel) {
  return kernel_score(grid, scan, scan.points_m.size(), T_map_sensor, kernel);
}

}  // namespace sightline
