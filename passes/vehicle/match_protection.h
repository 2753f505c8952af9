#pragma once

#include <optional>

#include "formats/model/place_kind.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/covariance/protection.h"
#include "passes/vehicle/sightline_localizer.h"

// How the errors of a place enter an answer of the C interface.

namespace sightline {

// What is known before a match.
struct MatchKnowledge {
  std::optional<Matrix6d> start_covariance;
  InformationScale scale = default_information_scale();
  PlaceKind kind = PlaceKind::kUnknown;
  double protection_risk = 0.0;  // 0: no level is available
};

// Nothing where an option makes no sense. Numbers of a place that are given replace those of its
// kind, and no level was calibrated for them.
std::optional<MatchKnowledge> knowledge_of(const sightline_match_options* options, PlaceKind kind);

// Levels, integrity and kind of place; `answer` already has its point count and stop.
void put_protection(const MatchKnowledge& knowledge, const MatchResult& found, const MatchEnd& end,
                    sightline_match& answer);
void put_unavailable(sightline_match& answer);

}  // namespace sightline
