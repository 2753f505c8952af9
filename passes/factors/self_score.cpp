#include "passes/factors/self_score.h"

#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"
#include "passes/factors/vicinity.h"
#include "passes/matching/grid/match_grid.h"

// The 17 x 17 shifted copies of a sample fall into few cells (nine at most where cells are 2 m), so
// the cell is looked up once for each rectangle of shifts that shares it, not once for each shift.

namespace sightline {
namespace {

// A run of shifts along one axis that put the sample into the same cell.
struct ShiftRun {
  std::int32_t key = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

// A sample's coordinate under each shift along one axis, and the runs of cells they fall into.
struct ShiftedAxis {
  std::array<double, kShiftsPerAxis> position_m;
  std::array<ShiftRun, kShiftsPerAxis> runs;
  std::size_t run_count = 0;
};

ShiftedAxis shift_along_axis(double position_m, double cell_m) {
  ShiftedAxis axis;
  for (std::size_t i = 0; i < kShiftsPerAxis; ++i) {
    axis.position_m[i] = position_m + kShiftStep_m * (static_cast<double>(i) - kShiftReach);
    const std::int32_t key = floor_to_int(axis.position_m[i] / cell_m);
    if (i == 0 || axis.runs[axis.run_count - 1].key != key) {
      axis.runs[axis.run_count++] = {key, i, i};
    }
    axis.runs[axis.run_count - 1].end = i + 1;
  }
  return axis;
}

void add_sample(const Eigen::Vector3d& sample_m, const MatchGrid& receivers, ShiftGrid& score) {
  const ShiftedAxis x = shift_along_axis(sample_m.x(), receivers.cell_m);
  const ShiftedAxis y = shift_along_axis(sample_m.y(), receivers.cell_m);
  const std::int32_t key_z = floor_to_int(sample_m.z() / receivers.cell_m);
  const double factor = -0.5 * receivers.gauss.d2;
  for (const ShiftRun& row : std::span(y.runs).first(y.run_count)) {
    for (const ShiftRun& column : std::span(x.runs).first(x.run_count)) {
      const std::int32_t index = nd_of_cell(receivers, {column.key, row.key, key_z});
      if (index == MatchGrid::kNone) continue;
      const MatchNd& nd = receivers.nds[static_cast<std::size_t>(index)];
      const Eigen::Matrix3d& information = nd.information_per_m2;
      const double dz = sample_m.z() - nd.mean_m.z();
      for (std::size_t j = row.begin; j < row.end; ++j) {
        // The square of the Mahalanobis distance along a row of shifts is a + b dx + c dx^2.
        const double dy = y.position_m[j] - nd.mean_m.y();
        const double a = information(1, 1) * dy * dy + information(2, 2) * dz * dz +
                         2.0 * information(1, 2) * dy * dz;
        const double b = 2.0 * (information(0, 1) * dy + information(0, 2) * dz);
        for (std::size_t i = column.begin; i < column.end; ++i) {
          const double dx = x.position_m[i] - nd.mean_m.x();
          const double maha2 = a + dx * (b + information(0, 0) * dx);
          score[j * kShiftsPerAxis + i] += portable_exp(factor * maha2);
        }
      }
    }
  }
}

}  // namespace

ShiftGrid self_score(const Nd& sender, const MatchGrid& receivers) {
  ShiftGrid score{};
  add_sample(sender.mean_m, receivers, score);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector3d spread_m =
        std::sqrt(sender.eigenvalues_m2[axis]) * sender.eigenvectors.col(axis);
    add_sample(sender.mean_m + spread_m, receivers, score);
    add_sample(sender.mean_m - spread_m, receivers, score);
  }
  return score;
}

std::vector<ShiftGrid> self_scores(const Vicinity& vicinity, std::span<const ShiftGrid> score_of) {
  std::vector<ShiftGrid> by_range;
  ShiftGrid sum{};
  for (std::size_t range = 0; range < vicinity.ranges_m.size(); ++range) {
    for (std::size_t i = vicinity.shell_begin(range); i < vicinity.end[range]; ++i) {
      const ShiftGrid& score = score_of[vicinity.nd_index[i]];
      for (std::size_t shift = 0; shift < kShiftCount; ++shift) sum[shift] += score[shift];
    }
    by_range.push_back(sum);
  }
  return by_range;
}

double score_entropy(const ShiftGrid& self_score) {
  constexpr double kTemperature = 0.1;  // of the largest score
  const double largest = *std::max_element(self_score.begin(), self_score.end());
  if (!(largest > 0.0)) return portable_log2(static_cast<double>(kShiftCount));
  ShiftGrid weight;
  double total = 0.0;
  for (std::size_t shift = 0; shift < kShiftCount; ++shift) {
    // Less the largest exponent, which the division by the total takes out again.
    weight[shift] = portable_exp((self_score[shift] / largest - 1.0) / kTemperature);
    total += weight[shift];
  }
  return entropy_bits(weight, total);
}

double flat_050(const ShiftGrid& self_score) {
  constexpr double kNear_m = 0.375;
  constexpr double kFar_m = 0.625;
  constexpr std::size_t kNoShift = kShiftCount / 2;
  if (!(self_score[kNoShift] > 0.0)) return 1.0;
  double largest = 0.0;
  for (int j = -kShiftReach; j <= kShiftReach; ++j) {
    for (int i = -kShiftReach; i <= kShiftReach; ++i) {
      const double shift_m = portable_hypot(kShiftStep_m * i, kShiftStep_m * j);
      if (shift_m < kNear_m || shift_m >= kFar_m) continue;
      const int index = (j + kShiftReach) * static_cast<int>(kShiftsPerAxis) + i + kShiftReach;
      largest = std::max(largest, self_score[static_cast<std::size_t>(index)]);
    }
  }
  return largest / self_score[kNoShift];
}

}  // namespace sightline
