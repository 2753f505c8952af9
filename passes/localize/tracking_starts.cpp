#include "passes/localize/tracking_starts.h"

#include <numbers>

#include "formats/base/portable_math.h"
#include "formats/base/units.h"

namespace sightline {
namespace {

constexpr int kFewest = 5;  // whose cosines and sines of one and two turns are orthogonal

}  // namespace

std::vector<InitialOffset> tracking_offsets(const TrackingPattern& pattern) {
  std::vector<InitialOffset> offsets;
  for (int k = 0; k < pattern.count; ++k) {
    const double angle_rad = 2.0 * std::numbers::pi * k / pattern.count;
    const SinCos once = portable_sin_cos(angle_rad);
    const SinCos twice = portable_sin_cos(2.0 * angle_rad);
    constexpr double kUnit = std::numbers::sqrt2;  // the mean square of cosine and sine is a half
    InitialOffset offset;
    offset.x_m = kUnit * pattern.horizontal_m * once.cos;
    offset.y_m = kUnit * pattern.horizontal_m * once.sin;
    offset.z_m = kUnit * pattern.height_m * twice.sin;
    offset.yaw_rad = kUnit * pattern.yaw_deg * kRadPerDeg * twice.cos;
    offsets.push_back(offset);
  }
  return offsets;
}

Matrix6d tracking_covariance(const TrackingPattern& pattern, const Eigen::Matrix3d& vehicle_axes) {
  const double turn_rad = pattern.yaw_deg * kRadPerDeg;
  const Eigen::Vector3d deviations_m(pattern.horizontal_m, pattern.horizontal_m, pattern.height_m);
  const Eigen::Matrix3d scaled = vehicle_axes * deviations_m.asDiagonal();
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() = scaled * scaled.transpose();
  covariance.bottomRightCorner<3, 3>().diagonal().setConstant(turn_rad * turn_rad);
  return covariance;
}

Result<void> validate(const TrackingPattern& pattern) {
  if (pattern.count == 0 || pattern.count >= kFewest) return {};
  return Error{ErrorCode::kBadValue, concat("found ", pattern.count,
                                            " tracking starts, expected 0 or at least ", kFewest)};
}

}  // namespace sightline
