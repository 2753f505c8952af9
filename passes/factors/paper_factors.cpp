#include "passes/factors/paper_factors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"
#include "passes/matching/grid/match_grid.h"

namespace sightline {
namespace {

constexpr int kSectors = 18;
constexpr int kBands = 4;
// On a sphere area goes with height: the cap of one bin is 1/73 of the upper half high, and each
// band of 18 bins 18/73.
constexpr double kCapBegin = 72.0 / 73.0;
constexpr double kBandHeight = 18.0 / 73.0;

// Shannon entropy in bits of a histogram with the given total; 0 log 0 = 0, and 0 where it is
// empty.
double entropy_bits(std::span<const double> histogram, double total) {
  double entropy = 0.0;
  for (const double count : histogram) {
    if (count > 0.0) entropy -= count / total * portable_log2(count / total);
  }
  return entropy;
}

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

// The 17 x 17 shifted copies of a sample fall into few cells (nine at most where cells are 2 m), so
// the cell is looked up once for each rectangle of shifts that shares it, not once for each shift.
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

Vicinity vicinity_of(const Eigen::Vector3d& p_map_m, std::span<const Nd> nds,
                     std::span<const std::uint32_t> candidates,
                     const std::vector<double>& ranges_m) {
  struct Neighbour {
    double distance_m;
    std::uint32_t nd;
  };
  std::vector<Neighbour> neighbours;
  neighbours.reserve(candidates.size());
  for (const std::uint32_t nd : candidates) {
    const double distance_m = (nds[nd].mean_m - p_map_m).norm();
    if (distance_m <= ranges_m.back()) neighbours.push_back({distance_m, nd});
  }
  std::sort(neighbours.begin(), neighbours.end(), [&](const Neighbour& a, const Neighbour& b) {
    if (a.distance_m != b.distance_m) return a.distance_m < b.distance_m;
    return nds[a.nd].key < nds[b.nd].key;
  });
  Vicinity vicinity;
  vicinity.ranges_m = ranges_m;
  for (const Neighbour& neighbour : neighbours) {
    vicinity.nd_index.push_back(neighbour.nd);
    vicinity.distance_m.push_back(neighbour.distance_m);
  }
  for (const double range_m : ranges_m) {
    const auto beyond =
        std::upper_bound(vicinity.distance_m.begin(), vicinity.distance_m.end(), range_m);
    vicinity.end.push_back(static_cast<std::size_t>(beyond - vicinity.distance_m.begin()));
  }
  return vicinity;
}

std::vector<ByDimension> dimension_counts(const Vicinity& vicinity,
                                          std::span<const int> dimension_class_of) {
  std::vector<ByDimension> by_range;
  ByDimension counts{};
  for (std::size_t range = 0; range < vicinity.ranges_m.size(); ++range) {
    for (std::size_t i = vicinity.shell_begin(range); i < vicinity.end[range]; ++i) {
      counts[static_cast<std::size_t>(dimension_class_of[vicinity.nd_index[i]] - 1)] += 1.0;
    }
    by_range.push_back(counts);
  }
  return by_range;
}

ByDimension dimension_ratios(const ByDimension& counts) {
  const double total = counts[0] + counts[1] + counts[2];
  if (total == 0.0) return {};
  return {counts[0] / total, counts[1] / total, counts[2] / total};
}

std::vector<double> feature_count(const Vicinity& vicinity) {
  return {vicinity.end.begin(), vicinity.end.end()};
}

int normal_bin(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d up = normal.z() < 0.0 ? Eigen::Vector3d(-normal) : normal;
  if (up.z() >= kCapBegin) return 0;
  const int band = std::min(static_cast<int>(up.z() / kBandHeight), kBands - 1);
  double azimuth_deg = portable_atan2(up.y(), up.x()) * 180.0 / std::numbers::pi;
  if (azimuth_deg < 0.0) azimuth_deg += 360.0;
  // On the rim n and -n are both up: there 18 sectors of 10 degrees go round twice.
  const double width_deg = band == 0 ? 10.0 : 20.0;
  const int sector = static_cast<int>(std::floor((azimuth_deg + width_deg / 2.0) / width_deg));
  return 1 + kSectors * band + sector % kSectors;
}

std::vector<double> normal_entropy(const Vicinity& vicinity, std::span<const int> normal_bin_of) {
  std::vector<double> entropy;
  std::array<double, kNormalBinCount> histogram{};
  double total = 0.0;
  for (std::size_t range = 0; range < vicinity.ranges_m.size(); ++range) {
    for (std::size_t i = vicinity.shell_begin(range); i < vicinity.end[range]; ++i) {
      const int bin = normal_bin_of[vicinity.nd_index[i]];
      if (bin < 0) continue;
      histogram[static_cast<std::size_t>(bin)] += 1.0;
      total += 1.0;
    }
    entropy.push_back(entropy_bits(histogram, total));
  }
  return entropy;
}

std::vector<double> occupancy_ratio(std::span<const float> distance_m,
                                    const std::vector<double>& ranges_m) {
  // Cells by the first range that reaches them, then running sums over ranges.
  std::vector<std::size_t> first_reached(ranges_m.size() + 1, 0);
  std::size_t in_view = 0;
  for (const float distance : distance_m) {
    if (std::isnan(distance)) continue;
    ++in_view;
    const auto range =
        std::lower_bound(ranges_m.begin(), ranges_m.end(), static_cast<double>(distance));
    ++first_reached[static_cast<std::size_t>(range - ranges_m.begin())];
  }
  std::vector<double> ratio;
  const double cells = std::max(1.0, static_cast<double>(in_view));
  std::size_t occupied = 0;
  for (std::size_t range = 0; range < ranges_m.size(); ++range) {
    occupied += first_reached[range];
    ratio.push_back(static_cast<double>(occupied) / cells);
  }
  return ratio;
}

std::vector<double> r_average(const Vicinity& vicinity) {
  std::vector<double> average_m;
  double sum_m = 0.0;
  for (std::size_t range = 0; range < vicinity.ranges_m.size(); ++range) {
    for (std::size_t i = vicinity.shell_begin(range); i < vicinity.end[range]; ++i) {
      sum_m += vicinity.distance_m[i];
    }
    const std::size_t count = vicinity.end[range];
    average_m.push_back(count == 0 ? vicinity.ranges_m[range] : sum_m / static_cast<double>(count));
  }
  return average_m;
}

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
