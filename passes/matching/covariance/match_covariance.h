#pragma once

#include <cstdint>
#include <optional>

#include "formats/geometry.h"
#include "passes/matching/covariance/structure_information.h"
#include "passes/matching/match_score.h"

// How wrong the pose of a match may be ("Covariance of a match" in schemas/definitions.md, v1).
// Matrices in map axes; order dx dy dz wx wy wz about the vehicle's origin, m and rad.

namespace sightline {

// How errors of matches compare with structure_information(). The defaults were fitted to matches
// in generated worlds; a map may have those of a place.
struct InformationScale {
  double variance_factor = 1.0;  // of errors that differ from cell to cell, to those assumed
  double map_m = 0.0;            // errors that all cells in view share, along each axis
  double map_rad = 0.0;          // about each axis
};
InformationScale default_information_scale();

// (factor structure^-1 + map + d d^T)^-1, which exists where the structure's information is
// singular too. d is the step from the match to where the residuals of structures are least: a
// match that contradicts the structures is that far off, or they are.
Matrix6d match_information(const StructureEvidence& structure, const InformationScale& scale);

// Of a start of unknown accuracy: 100 m and 1 rad.
Matrix6d unknown_start_covariance();

// Symmetric, finite, and no variance below 0.
bool is_covariance(const Matrix6d& matrix);

// Of a match with that information, from a start with that covariance:
// (information + (start + wander)^-1)^-1, which exists where either is singular. A motion without
// information keeps the start's error, and the match moves it to where the score is best by chance,
// up to as far as it searches: wander is 0.6 m and 0.01 rad.
Matrix6d match_covariance(const Matrix6d& information, const Matrix6d& start);

// Bits 0 to 5: forward, left, up, roll, pitch, yaw of the vehicle's axes. Set where the standard
// deviation without a start's information is above 0.25 m or 0.02 rad.
std::uint32_t weak_axes(const Matrix6d& information, const Pose& T_map_vehicle);

}  // namespace sightline
