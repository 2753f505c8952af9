#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "formats/surroundings/ndt_map.h"
#include "passes/matching/grid/match_grid.h"

// Factors of the NDs around a site: the paper's, and flat_050, which is made of its score.

namespace sightline {

// The NDs around one site, seen or not, nearest first (ties by cell key): those within ranges_m[r]
// are the first end[r].
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

// How well a part of the map matches the whole map when it is moved sideways (paper, Eq. 5; exact
// in schemas/definitions.md, `score_entropy`): shifts along x and y, in steps.
inline constexpr int kShiftReach = 8;  // to each side
inline constexpr double kShiftStep_m = 0.25;
inline constexpr std::size_t kShiftsPerAxis = 2 * kShiftReach + 1;
inline constexpr std::size_t kShiftCount = kShiftsPerAxis * kShiftsPerAxis;  // 289

// One value for each shift v = kShiftStep_m (i, j, 0), at (j + 8) * 17 + (i + 8).
using ShiftGrid = std::array<double, kShiftCount>;

// Over the five samples mu, mu +- sigma1 e1, mu +- sigma2 e2 of an ND, the sum of exp(-d2/2 m^2)
// with the ND of the cell that the shifted sample falls into. The same for every site.
ShiftGrid self_score(const Nd& sender, const MatchGrid& receivers);

// S(v) of each range: self scores summed over the senders within it, nearest first.
// score_of[i] belongs to nds[i].
std::vector<ShiftGrid> self_scores(const Vicinity& vicinity, std::span<const ShiftGrid> score_of);

// Entropy in bits of softmax(S / (0.1 max S)) over the 289 shifts (paper, section IV-F; the softmax
// is ours, schemas/definitions.md says why); log2 289 where S is 0 everywhere.
double score_entropy(const ShiftGrid& self_score);

// Largest self score over the shifts of 0.375 <= |v| < 0.625 m, over that of no shift. 1 where
// nothing scores; not clamped.
double flat_050(const ShiftGrid& self_score);

}  // namespace sightline
