#pragma once

#include <optional>

#include "formats/model/place_kind.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/covariance/protection.h"

// How the errors of a place enter a match and its protection levels.

namespace sightline {

// As the caller gives them; 0: default.
struct GivenErrors {
  const double* start_covariance = nullptr;  // 36 numbers
  double variance_factor = 0.0;
  double map_m = 0.0;
  double map_rad = 0.0;
  double protection_risk = 0.0;
};

// What is known before a match.
struct MatchKnowledge {
  std::optional<Matrix6d> start_covariance;
  InformationScale scale = default_information_scale();
  PlaceKind kind = PlaceKind::kUnknown;
  double protection_risk = 0.0;  // 0: no level is available
};

// Nothing where a number makes no sense. Numbers of a place that are given replace those of its
// kind, and no level was calibrated for them.
std::optional<MatchKnowledge> knowledge_of(const GivenErrors& given, PlaceKind kind);

const ProtectionRow& protection_row(PlaceKind kind);

// Infinite where no level is available.
ProtectionFactors levels_of_match(const MatchKnowledge& knowledge, const PoseEstimate& estimate);

}  // namespace sightline
