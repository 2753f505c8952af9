#pragma once

#include "passes/factors/paper/self_score.h"

namespace sightline {

// Largest self score over the shifts of about half a metre (0.375 <= |v| < 0.625 m), over that of
// no shift: how easily half a metre goes unnoticed. 1 where nothing scores; not clamped.
double flat_050(const ShiftGrid& self_score);

}  // namespace sightline
