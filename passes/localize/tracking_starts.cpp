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

Result<void> validate(const TrackingPattern& pattern) {
  if (pattern.count == 0 || pattern.count >= kFewest) return {};
  return Error{ErrorCode::kBadValue, concat("found ", pattern.count,
                                            " tracking starts, expected 0 or at least ", kFewest)};
}

}  // namespace sightline
