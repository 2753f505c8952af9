#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// The NDs around one site, nearest first (ties by cell key), cut into shells by the ranges: those
// within ranges_m[r] are the first end[r]. Whether they can be seen does not matter.
struct Vicinity {
  std::vector<double> ranges_m;         // ascending
  std::vector<std::size_t> end;         // per range
  std::vector<std::uint32_t> nd_index;  // into the list that it was made from
  std::vector<double> distance_m;       // of each mean from the site, ascending

  [[nodiscard]] std::size_t shell_begin(std::size_t range) const {
    return range == 0 ? 0 : end[range - 1];
  }
};

// `candidates` are indices into `nds`, in any order, each once; what lies beyond the longest range
// is left out.
Vicinity vicinity_of(const Eigen::Vector3d& p_map_m, std::span<const Nd> nds,
                     std::span<const std::uint32_t> candidates,
                     const std::vector<double>& ranges_m);

// Shannon entropy in bits of a histogram with the given total; 0 log 0 = 0, and 0 where it is
// empty.
inline double entropy_bits(std::span<const double> histogram, double total) {
  double entropy = 0.0;
  for (const double count : histogram) {
    if (count > 0.0) entropy -= count / total * portable_log2(count / total);
  }
  return entropy;
}

// NDs of class 1, 2 and 3 (element 0, 1, 2).
using ByDimension = std::array<double, 3>;

// d1_count, d2_count, d3_count of each range (paper, section IV-B; classes by Eq. 1).
// dimension_class_of[i] is the class of nds[i], as dimension_class() gives it.
std::vector<ByDimension> dimension_counts(const Vicinity& vicinity,
                                          std::span<const int> dimension_class_of);

// Share of each class among all; all 0 where there is none.
ByDimension dimension_ratios(const ByDimension& counts);

// Number of NDs within each range (paper, section IV-A).
std::vector<double> feature_count(const Vicinity& vicinity);

// Directions without sign, in bins of equal area.
inline constexpr int kNormalBinCount = 73;

// The bin of a normal of unit length; n and -n give the same one (schemas/definitions.md,
// `normal_entropy`): 0 is the cap around the vertical, 1 + 18 band + sector the others.
int normal_bin(const Eigen::Vector3d& normal);

// Entropy of the normals' directions over planar (2D) NDs, bits, of each range (paper, Eq. 3);
// normal_bin_of[i] belongs to nds[i] and is negative where that ND is not planar.
std::vector<double> normal_entropy(const Vicinity& vicinity, std::span<const int> normal_bin_of);

// Share of a depth image's cells whose first hit lies within each range (paper, Eq. 2). Every cell
// in view weighs the same; +inf is no hit, NaN out of view. 0 where no cell is in view.
std::vector<double> occupancy_ratio(std::span<const float> distance_m,
                                    const std::vector<double>& ranges_m);

// Mean distance of the NDs within each range, m (paper, Eq. 4, which lost its 1/m); the range
// itself where there is none.
std::vector<double> r_average(const Vicinity& vicinity);

}  // namespace sightline
