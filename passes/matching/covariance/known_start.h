#pragma once

#include "formats/geometry.h"
#include "passes/matching/covariance/match_covariance.h"
#include "passes/matching/covariance/structure_information.h"
#include "passes/matching/matcher.h"

// What a match says of the vehicle's pose, with and without a start of known covariance
// ("Covariance of a match" in schemas/definitions.md, v2). Matrices in map axes; order dx dy dz wx
// wy wz about the vehicle's origin, m and rad.

namespace sightline {

struct KnownStart {
  Pose T_map_vehicle = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};

// How far from such a start another optimum is looked for: three standard deviations of its least
// known horizontal direction.
double search_of_start_m(const Matrix6d& start);

// The motion that takes one pose to the other, as moved() applies it; turns up to a radian.
Vector6d motion_between(const Pose& T_map_from, const Pose& T_map_to);

struct PoseEstimate {
  Pose T_map_vehicle = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};

// The most probable pose, where scan and map constrain a match that ended there with `information`,
// and the start is normally distributed: without information it is the start. Its covariance is
// (information + start^-1)^-1, which exists where either is singular.
PoseEstimate pose_of_known_start(const Pose& T_map_found, const Matrix6d& information,
                                 const KnownStart& start);

// Of a match.
struct MatchEnd {
  PoseEstimate estimate;
  Matrix6d information = Matrix6d::Zero();  // match_information(), at the end of the match
  std::uint32_t weak = 0;                   // weak_axes()
  bool holds_every_motion = false;          // StructureEvidence's
  RaisedPoints raised;                      // of the points that information uses
};

// `scan`: as it was matched. `start`: null where its covariance is unknown; the estimate is then
// where the match ended. Of a match without any scored point it is the start. Allocates nothing
// once such scans were seen.
MatchEnd end_of_match(const MatchResult& found, const ScanForMatch& scan, const KnownStart* start,
                      const StructureMap& map, const InformationScale& scale,
                      StructureObserver& memory);

}  // namespace sightline
