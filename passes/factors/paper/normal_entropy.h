#pragma once

#include <span>
#include <vector>

#include "passes/factors/paper/vicinity.h"

namespace sightline {

// Directions without sign, in bins of equal area.
inline constexpr int kNormalBinCount = 73;

// The bin of a normal of unit length; n and -n give the same one (schemas/definitions.md,
// `normal_entropy`): 0 is the cap around the vertical, 1 + 18 band + sector the others.
int normal_bin(const Eigen::Vector3d& normal);

// Entropy of the normals' directions over planar (2D) NDs, bits, of each range (paper, Eq. 3);
// normal_bin_of[i] belongs to nds[i] and is negative where that ND is not planar.
std::vector<double> normal_entropy(const Vicinity& vicinity, std::span<const int> normal_bin_of);

}  // namespace sightline
