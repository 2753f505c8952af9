#pragma once

#include "passes/matching/covariance/known_start.h"
#include "passes/matching/match_score.h"
#include "passes/vehicle/match_protection.h"
#include "passes/vehicle/sightline_localizer.h"

// What a match answers through the C interface.

namespace sightline {

// The answer of a call that is refused.
void put_start(const double T_world_start[12], sightline_match& answer);

void put(const MatchResult& found, sightline_match& answer);
void put(const MatchEnd& end, const MapFrame& frame, sightline_match& answer);
void put(const RaisedPoints& raised, sightline_match& answer);
// Of a match whose point count and stop are in `answer`.
void put_protection(const MatchKnowledge& knowledge, const MatchResult& found, const MatchEnd& end,
                    sightline_match& answer);

}  // namespace sightline
