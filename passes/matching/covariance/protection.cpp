#include "passes/matching/covariance/protection.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

constexpr std::uint32_t kDoubtful = 2;
constexpr std::uint32_t kLost = 4;
constexpr std::uint32_t kMostDoubt = 6;
constexpr int kMotionOfAxis[] = {0, 1, 2, 5};

}  // namespace

ProtectionFactors protection_levels(const PoseEstimate& estimate, const ProtectionRow& row,
                                    double risk) {
  ProtectionFactors levels = protection_factors(row, risk);
  for (std::size_t i = 0; i < kProtectionAxes; ++i) {
    const int first = kMotionOfAxis[i] < 3 ? 0 : 3;
    const Eigen::Vector3d axis = estimate.T_map_vehicle.linear().col(kMotionOfAxis[i] - first);
    const double variance = axis.dot(estimate.covariance.block<3, 3>(first, first) * axis);
    if (std::isfinite(levels[i])) levels[i] *= std::sqrt(std::max(variance, 0.0));
  }
  return levels;
}

Integrity integrity_of(const MatchResult& found, std::size_t point_count,
                       const ProtectionRow& row) {
  if (found.scored_points == 0 || point_count == 0) return Integrity::kUnknown;
  const double share = static_cast<double>(found.scored_points) / static_cast<double>(point_count);
  const bool is_usual =
      found.nearest_voxel_likelihood >= row.least_likelihood && share >= row.least_scored_share;
  return is_usual ? Integrity::kOk : Integrity::kDoubtful;
}

double IntegrityMonitor::raised_met_share() const {
  constexpr double kMore = 8.0;
  return (raised_met_count + kMore) / (raised_count + kMore);
}

Integrity IntegrityMonitor::add(Integrity match, const RaisedPoints& raised,
                                const ProtectionRow& row) {
  constexpr double kKept = 0.9;
  raised_count = kKept * raised_count + raised.count;
  raised_met_count = kKept * raised_met_count + raised.met_count;
  if (match == Integrity::kOk) {
    doubt -= doubt > 0 ? 1 : 0;
  } else {
    doubt = std::min(doubt + 1, kMostDoubt);
  }
  if (doubt >= kLost) return Integrity::kLost;
  const bool is_elsewhere = raised_met_share() < row.least_raised_share;
  if (doubt >= kDoubtful || is_elsewhere) return Integrity::kDoubtful;
  return match == Integrity::kUnknown ? Integrity::kUnknown : Integrity::kOk;
}

}  // namespace sightline
