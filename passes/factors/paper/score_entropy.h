#pragma once

#include "passes/factors/paper/self_score.h"

namespace sightline {

// Entropy in bits of softmax(S / (0.1 max S)) over the 289 shifts (paper, section IV-F; the softmax
// is ours, schemas/definitions.md says why); log2 289 where S is 0 everywhere.
double score_entropy(const ShiftGrid& self_score);

}  // namespace sightline
