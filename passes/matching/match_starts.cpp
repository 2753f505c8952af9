#include "passes/matching/match_starts.h"

#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr double kGoldenAngle_rad = 2.399963229728653;

// 0 .. count-1 to -1 .. 1 in even steps.
double evenly(int step, int count) { return count > 1 ? 2.0 * step / (count - 1) - 1.0 : 0.0; }

}  // namespace

std::vector<InitialOffset> initial_offsets(const StartPattern& pattern) {
  const int count = pattern.count;
  std::vector<InitialOffset> offsets;
  for (int k = 0; k < count; ++k) {
    const double radius_m = pattern.radius_m * std::sqrt((k + 0.5) / count);
    const SinCos direction = portable_sin_cos(kGoldenAngle_rad * k);
    InitialOffset offset;
    offset.x_m = radius_m * direction.cos;
    offset.y_m = radius_m * direction.sin;
    offset.z_m = pattern.z_m * evenly(7 * k % count, count);
    offset.yaw_rad = pattern.yaw_deg * evenly(5 * k % count, count) * std::numbers::pi / 180.0;
    offsets.push_back(offset);
  }
  return offsets;
}

Pose start_pose(const InitialOffset& offset) {
  Pose pose = Pose::Identity();
  const SinCos yaw = portable_sin_cos(offset.yaw_rad);
  pose.linear() << yaw.cos, -yaw.sin, 0.0, yaw.sin, yaw.cos, 0.0, 0.0, 0.0, 1.0;
  pose.translation() = Eigen::Vector3d(offset.x_m, offset.y_m, offset.z_m);
  return pose;
}

}  // namespace sightline
