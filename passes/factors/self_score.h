#pragma once

#include <array>
#include <span>
#include <vector>

#include "passes/factors/vicinity.h"
#include "passes/matching/grid/match_grid.h"

// How well a part of the map matches the whole map when it is moved sideways (paper, Eq. 5; exact
// in schemas/definitions.md, `score_entropy`).

namespace sightline {

inline constexpr int kShiftReach = 8;  // steps to each side
inline constexpr double kShiftStep_m = 0.25;
inline constexpr std::size_t kShiftsPerAxis = 2 * kShiftReach + 1;
inline constexpr std::size_t kShiftCount = kShiftsPerAxis * kShiftsPerAxis;  // 289

// One value for each shift v = kShiftStep_m (i, j, 0), at (j + 8) * 17 + (i + 8).
using ShiftGrid = std::array<double, kShiftCount>;

// What one ND sends to all NDs of the map, its own cell included: over its five samples mu,
// mu +- sigma1 e1, mu +- sigma2 e2, the sum of exp(-d2/2 m^2) with the ND of the cell that the
// shifted sample falls into. A property of the map: the same for every site that looks at the ND.
ShiftGrid self_score(const Nd& sender, const MatchGrid& receivers);

// S(v) of each range: self scores summed over the senders within it, nearest first.
// score_of[i] belongs to nds[i].
std::vector<ShiftGrid> self_scores(const Vicinity& vicinity, std::span<const ShiftGrid> score_of);

// Entropy in bits of softmax(S / (0.1 max S)) over the 289 shifts (paper, section IV-F; the softmax
// is ours, schemas/definitions.md says why); log2 289 where S is 0 everywhere.
double score_entropy(const ShiftGrid& self_score);

// Largest self score over the shifts of about half a metre (0.375 <= |v| < 0.625 m), over that of
// no shift: how easily half a metre goes unnoticed. 1 where nothing scores; not clamped.
double flat_050(const ShiftGrid& self_score);

}  // namespace sightline
