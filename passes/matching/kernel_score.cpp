#include "passes/matching/kernel_score.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "formats/base/check.h"

namespace sightline {
namespace {

// Sums in float go over this many points at most; from there on in double.
constexpr std::size_t kChunk = 1024;
static_assert(kChunk % kKernelBatch == 0);

// The globals of the matcher: every version gives the same bits, so no result depends on it.
std::atomic<MatchKernel> g_replacement = MatchKernel::kFastest;
std::atomic<const KernelVersion*> g_version = nullptr;

using Totals = std::array<double, kKernelSums>;

KernelVersion version_of(MatchKernel kernel) {
  SIGHTLINE_CHECK(is_supported(kernel));
  const KernelVersion* const version = g_version;
  if (kernel == MatchKernel::kFastest && version != nullptr) return *version;
  switch (kernel == MatchKernel::kFastest ? fastest_kernel() : kernel) {
#ifdef SIGHTLINE_X86_KERNELS
    case MatchKernel::kAvx2:
      return kernel_avx2();
    case MatchKernel::kAvx512:
      return kernel_avx512();
#endif
    default:
      return kernel_portable();
  }
}

constexpr double kReach = 0x1.0p30;  // cells

void fetch_cell(const void* grid, double cell_x, double cell_y, double cell_z) {
  if (std::abs(cell_x) > kReach || std::abs(cell_y) > kReach || std::abs(cell_z) > kReach) return;
  static_cast<const MatchGrid*>(grid)->cells.prefetch({static_cast<std::int32_t>(cell_x),
                                                       static_cast<std::int32_t>(cell_y),
                                                       static_cast<std::int32_t>(cell_z)});
}

std::int32_t find_record(const void* grid, double cell_x, double cell_y, double cell_z) {
  if (std::abs(cell_x) > kReach || std::abs(cell_y) > kReach || std::abs(cell_z) > kReach) return 0;
  const CellKey key{static_cast<std::int32_t>(cell_x), static_cast<std::int32_t>(cell_y),
                    static_cast<std::int32_t>(cell_z)};
  // Record 0 is the one without NDs; MatchGrid::kNone is -1.
  return find_cell(*static_cast<const MatchGrid*>(grid), key) + 1;
}

KernelInput make_input(const MatchGrid& grid, const Pose& T_map_sensor) {
  KernelInput input;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      input.rotation[3 * row + column] = T_map_sensor.linear()(row, column);
    }
    input.translation_m[row] = T_map_sensor.translation()[row];
  }
  input.cell_m = grid.cell_m;
  input.cells_per_m = 1.0 / grid.cell_m;
  input.records = grid.records.floats();
  input.places = grid.records.places.data();
  input.columns = grid.columns.records();
  input.find = find_record;
  input.fetch = fetch_cell;
  input.grid = &grid;
  return input;
}

void point_to_chunk(ScanForMatch& scan, std::size_t first, std::size_t end, KernelInput& input) {
  input.x_m = scan.x_m.data() + first;
  input.y_m = scan.y_m.data() + first;
  input.z_m = scan.z_m.data() + first;
  input.cell_x = scan.cell_x.data() + first;
  input.cell_y = scan.cell_y.data() + first;
  input.cell_z = scan.cell_z.data() + first;
  input.record = scan.record.data() + first;
  input.count = std::min(kChunk, end - first);
}

double sum_of(const float (&of_lane)[kKernelBatch]) {
  static_assert(kKernelBatch == 16);
  double lanes[8];
  for (int i = 0; i < 8; ++i) {
    lanes[i] = static_cast<double>(of_lane[i]) + static_cast<double>(of_lane[i + 8]);
  }
  for (int i = 0; i < 4; ++i) lanes[i] += lanes[i + 4];
  return (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
}

// The kernel's sums are over d1, and its information was times d2.
MatchScore to_score(const Totals& totals, double d1) {
  MatchScore score;
  score.score = -d1 * totals[0];
  score.nearest_sum = -d1 * totals[1];
  for (int i = 0; i < 6; ++i) score.gradient[i] = d1 * totals[2 + static_cast<std::size_t>(i)];
  std::size_t next = 8;
  const auto fill_symmetric = [&](int corner) {
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        score.hessian(corner + i, corner + j) = score.hessian(corner + j, corner + i) =
            d1 * totals[next++];
      }
    }
  };
  fill_symmetric(0);
  for (int i = 0; i < 3; ++i) {
    for (int j = 3; j < 6; ++j) score.hessian(i, j) = score.hessian(j, i) = d1 * totals[next++];
  }
  fill_symmetric(3);
  return score;
}

// Calls run(input) for a chunk after the other of the first `count` points.
template <class Run>
void for_chunks(const MatchGrid& grid, ScanForMatch& scan, std::size_t count,
                const Pose& T_map_sensor, const Run& run) {
  SIGHTLINE_CHECK(count == scan.points_m.size() ||
                  (count < scan.points_m.size() && count % kKernelBatch == 0));
  if (scan.cells_digest != grid.cells_digest) {
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    for (std::vector<double>* axis : {&scan.cell_x, &scan.cell_y, &scan.cell_z}) {
      std::ranges::fill(*axis, kUnknown);
    }
    std::ranges::fill(scan.record, 0);
    scan.cells_digest = grid.cells_digest;
  }
  KernelInput input = make_input(grid, T_map_sensor);
  for (std::size_t first = 0; first < count; first += kChunk) {
    point_to_chunk(scan, first, count, input);
    run(input);
  }
}

}  // namespace

std::string_view kernel_name(MatchKernel kernel) {
  constexpr std::string_view kNames[] = {"fastest", "portable", "avx2", "avx512", "exact"};
  return kNames[static_cast<std::size_t>(kernel)];
}

bool is_supported(MatchKernel kernel) {
#ifdef SIGHTLINE_X86_KERNELS
  const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool has_avx512 = has_avx2 && __builtin_cpu_supports("avx512f") &&
                          __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
  constexpr bool has_avx2 = false;
  constexpr bool has_avx512 = false;
#endif
  if (kernel == MatchKernel::kAvx2) return has_avx2;
  if (kernel == MatchKernel::kAvx512) return has_avx512;
  return true;
}

void replace_fastest_kernel(MatchKernel kernel) {
  SIGHTLINE_CHECK(is_supported(kernel));
  g_replacement = kernel;
}

void replace_fastest_kernel(const KernelVersion* version) { g_version = version; }

MatchKernel fastest_kernel() {
  const MatchKernel replacement = g_replacement;
  if (replacement != MatchKernel::kFastest) return replacement;
  if (is_supported(MatchKernel::kAvx512)) return MatchKernel::kAvx512;
  if (is_supported(MatchKernel::kAvx2)) return MatchKernel::kAvx2;
  return MatchKernel::kPortable;
}

ScanForMatch make_scan_for_match(std::span<const Eigen::Vector3d> points_m,
                                 std::size_t thin_stride) {
  ScanForMatch scan;
  fill_scan_for_match(points_m, thin_stride, scan);
  return scan;
}

void fill_scan_for_match(std::span<const Eigen::Vector3d> points_m, std::size_t thin_stride,
                         ScanForMatch& scan) {
  SIGHTLINE_CHECK(thin_stride >= 1);
  const std::size_t padded = (points_m.size() + kKernelBatch - 1) / kKernelBatch * kKernelBatch;
  scan.points_m.clear();
  scan.points_m.reserve(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); i += thin_stride) {
    scan.points_m.push_back(points_m[i]);
  }
  // Whole batches: a batch that is scored in part would go stale in its other part.
  scan.thin_count = std::min(
      points_m.size(), (scan.points_m.size() + kKernelBatch - 1) / kKernelBatch * kKernelBatch);
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (i % thin_stride != 0) scan.points_m.push_back(points_m[i]);
  }
  for (std::vector<double>* axis : {&scan.x_m, &scan.y_m, &scan.z_m}) axis->assign(padded, 0.0);
  for (std::vector<double>* axis : {&scan.cell_x, &scan.cell_y, &scan.cell_z}) axis->resize(padded);
  scan.record.resize(padded);
  scan.cells_digest = 0;  // of no grid: the first evaluation forgets the cells
  scan.farthest_m = 0.0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    scan.x_m[i] = scan.points_m[i].x();
    scan.y_m[i] = scan.points_m[i].y();
    scan.z_m[i] = scan.points_m[i].z();
    scan.farthest_m = std::max(scan.farthest_m, scan.points_m[i].norm());
  }
}

MatchScore kernel_score(const MatchGrid& grid, ScanForMatch& scan, std::size_t count,
                        const Pose& T_map_sensor, MatchKernel kernel) {
  if (kernel == MatchKernel::kExact) {
    return match_score(grid, std::span(scan.points_m).first(count), T_map_sensor);
  }
  const KernelVersion version = version_of(kernel);
  Totals totals{};
  KernelSums sums;
  for_chunks(grid, scan, count, T_map_sensor, [&](const KernelInput& input) {
    version.all(input, sums);
    for (std::size_t s = 0; s < kKernelSums; ++s) totals[s] += sum_of(sums.lanes[s]);
  });
  MatchScore score = to_score(totals, grid.gauss.d1);
  for (std::size_t i = 0; i < count; ++i) score.scored_points += scan.record[i] != 0 ? 1 : 0;
  return score;
}

double kernel_score_alone(const MatchGrid& grid, ScanForMatch& scan, std::size_t count,
                          const Pose& T_map_sensor, MatchKernel kernel) {
  if (kernel == MatchKernel::kExact) {
    return kernel_score(grid, scan, count, T_map_sensor, kernel).score;
  }
  const KernelVersion version = version_of(kernel);
  double total = 0.0;
  KernelSums sums;
  for_chunks(grid, scan, count, T_map_sensor, [&](const KernelInput& input) {
    version.score(input, sums);
    total += sum_of(sums.lanes[0]);
  });
  return -grid.gauss.d1 * total;
}

}  // namespace sightline
