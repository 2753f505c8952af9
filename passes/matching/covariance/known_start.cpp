#include "passes/matching/covariance/known_start.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "formats/symmetric_eigen.h"

namespace sightline {

double search_of_start_m(const Matrix6d& start) {
  constexpr double kDeviations = 3.0;
  const Eigen::Matrix2d horizontal = start.topLeftCorner<2, 2>();
  const double largest_m2 = symmetric_eigen<2>(horizontal).values[1];
  return kDeviations * std::sqrt(std::max(largest_m2, 0.0));
}

Vector6d motion_between(const Pose& T_map_from, const Pose& T_map_to) {
  const Eigen::Matrix3d turn = T_map_to.linear() * T_map_from.linear().transpose();
  Vector6d motion;
  motion << T_map_to.translation() - T_map_from.translation(), rotation_vector(turn);
  return motion;
}

// With P the start's covariance and I the information, the end keeps the share (1 + P I)^-1 of the
// start, and (1 + P I)^-1 P = (I + P^-1)^-1.
PoseEstimate pose_of_known_start(const Pose& T_map_found, const Matrix6d& information,
                                 const KnownStart& start) {
  Matrix6d sum = start.covariance * information;
  sum.diagonal().array() += 1.0;
  const Eigen::PartialPivLU<Matrix6d> factors(sum);
  PoseEstimate result;
  for (int i = 0; i < 6; ++i) result.covariance.col(i) = factors.solve(start.covariance.col(i));
  result.covariance = (0.5 * (result.covariance + result.covariance.transpose())).eval();
  const Vector6d kept = factors.solve(motion_between(T_map_found, start.T_map_vehicle));
  result.T_map_vehicle = moved(T_map_found, kept);
  return result;
}

MatchEnd end_of_match(const MatchResult& found, const ScanForMatch& scan, const KnownStart* start,
                      const StructureMap& map, const InformationScale& scale,
                      StructureObserver& memory) {
  MatchEnd end;
  end.estimate.T_map_vehicle = found.T_map_sensor;
  const bool is_matched = found.scored_points > 0;
  if (is_matched) {
    const StructureEvidence evidence = structure_evidence(map, scan, found.T_map_sensor, memory);
    end.information = match_information(evidence, scale);
    end.holds_every_motion = evidence.holds_every_motion;
    end.raised = evidence.raised;
  }
  const Matrix6d alone = covariance_of_unknown_start(end.information);
  end.weak = weak_axes(alone, found.T_map_sensor);
  if (start == nullptr) {
    end.estimate.covariance = alone;
  } else if (is_matched) {
    end.estimate = pose_of_known_start(found.T_map_sensor, end.information, *start);
  } else {
    end.estimate = {start->T_map_vehicle, start->covariance};
  }
  return end;
}

}  // namespace sightline
