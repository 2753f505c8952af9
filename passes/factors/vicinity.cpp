#include "passes/factors/vicinity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr int kSectors = 18;
constexpr int kBands = 4;
// On a sphere area goes with height: the cap of one bin is 1/73 of the upper half high, and each
// band of 18 bins 18/73.
constexpr double kCapBegin = 72.0 / 73.0;
constexpr double kBandHeight = 18.0 / 73.0;

int sector_of(double azimuth_deg, double width_deg) {
  const int sector = static_cast<int>(std::floor((azimuth_deg + width_deg / 2.0) / width_deg));
  return sector % kSectors;
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
  const int sector = sector_of(azimuth_deg, band == 0 ? 10.0 : 20.0);
  return 1 + kSectors * band + sector;
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

}  // namespace sightline
