#pragma once

#include <cstddef>

#include "formats/drive/look.h"
#include "formats/geometry.h"
#include "passes/matching/matcher.h"

namespace sightline {

// Of a match of so many points that was started from the predicted pose. Finite for any match.
// Allocates nothing.
LookSigns look_signs(const MatchResult& match, std::size_t point_count,
                     const Pose& T_map_predicted);

}  // namespace sightline
