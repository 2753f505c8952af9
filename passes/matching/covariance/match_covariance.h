#pragma once

#include <cstdint>

#include "formats/geometry.h"
#include "passes/matching/covariance/structure_information.h"
#include "passes/matching/match_score.h"

// How wrong the pose of a match may be ("Covariance of a match" in schemas/definitions.md, v2).
// Matrices in map axes; order dx dy dz wx wy wz about the vehicle's origin, m and rad.

namespace sightline {

// How errors of matches compare with structure_information(). The defaults were fitted to matches
// in generated worlds; a map may have those of a place.
struct InformationScale {
  double variance_factor = 1.0;    // of errors that differ from cell to cell, to those assumed
  double map_m = 0.0;              // errors that all cells in view share, along each axis
  double map_rad = 0.0;            // about each axis
  double covariance_factor = 1.0;  // that the result of all that is multiplied by
};
InformationScale default_information_scale();

// (factor structure^-1 + map + d d^T)^-1 / covariance_factor, which exists where the structure's
// information is singular too. d is the step from the match to where the residuals of structures
// are least: a match that contradicts the structures is that far off, or they are.
Matrix6d match_information(const StructureEvidence& structure, const InformationScale& scale);

// Symmetric, finite, and no variance below 0.
bool is_covariance(const Matrix6d& matrix);

// Of a match with that information from a start of unknown accuracy, taken for 100 m and 1 rad.
Matrix6d covariance_of_unknown_start(const Matrix6d& information);

// Bits 0 to 5: forward, left, up, roll, pitch, yaw of the vehicle's axes. Set where the standard
// deviation from a start of unknown accuracy is above 0.25 m or 0.02 rad.
std::uint32_t weak_axes(const Matrix6d& covariance, const Pose& T_map_vehicle);

}  // namespace sightline
