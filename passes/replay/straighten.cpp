#include "passes/replay/straighten.h"

#include <algorithm>
#include <array>

#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

constexpr std::size_t kSteps = 64;

using Rows = Eigen::Matrix<double, 3, 4>;

// The motion of the sensor from the stamp to times evenly from first_ns to last_ns.
std::array<Rows, kSteps + 1> sampled(const VehicleMotion& motion, const Pose& T_vehicle_sensor,
                                     double first_ns, double last_ns) {
  const Pose T_sensor_vehicle = T_vehicle_sensor.inverse(Eigen::Isometry);
  std::array<Rows, kSteps + 1> samples;
  for (std::size_t i = 0; i <= kSteps; ++i) {
    const double time_ns = first_ns + (last_ns - first_ns) * static_cast<double>(i) / kSteps;
    const double share = time_ns / static_cast<double>(motion.duration_ns);
    const Pose moved = predicted_pose(Pose::Identity(), motion.T_before_after, share);
    samples[i] = (T_sensor_vehicle * moved * T_vehicle_sensor).affine();
  }
  return samples;
}

}  // namespace

void straighten(Scan& scan, const VehicleMotion& motion, const Pose& T_vehicle_sensor) {
  if (scan.time_offset_ns.empty()) return;
  const auto [first, last] = std::ranges::minmax(scan.time_offset_ns);
  if (motion.duration_ns > 0 && first < last) {
    const double span_ns = static_cast<double>(last) - first;
    const std::array<Rows, kSteps + 1> samples =
        sampled(motion, T_vehicle_sensor, first, static_cast<double>(last));
    for (std::size_t i = 0; i < scan.points_m.size(); ++i) {
      const double place = (static_cast<double>(scan.time_offset_ns[i]) - first) / span_ns * kSteps;
      const std::size_t step = std::min(static_cast<std::size_t>(place), kSteps - 1);
      const double share = place - static_cast<double>(step);
      const Rows T_stamp_point = (1.0 - share) * samples[step] + share * samples[step + 1];
      const Eigen::Vector3d point_m = scan.points_m[i];
      scan.points_m[i] = T_stamp_point.leftCols<3>() * point_m + T_stamp_point.col(3);
    }
  }
  scan.time_offset_ns.clear();
}

}  // namespace sightline
