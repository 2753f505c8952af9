#include "passes/matching/autoware_sampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/random.h"

namespace sightline {
namespace {

// No corner of the box is farther from the vehicle, so nothing is cut but by the box.
constexpr double kBeyondBox_m = 100.0;

bool is_in_box(const Eigen::Vector3d& p_vehicle_m) {
  return std::abs(p_vehicle_m.x()) <= AutowareSampler::kBox_m &&
         std::abs(p_vehicle_m.y()) <= AutowareSampler::kBox_m &&
         p_vehicle_m.z() >= -AutowareSampler::kBoxBelow_m &&
         p_vehicle_m.z() <= AutowareSampler::kBoxAbove_m;
}

// `count` of the points, each as likely as any other: the first steps of a shuffle.
void keep_random(std::size_t count, Random random, std::vector<Eigen::Vector3d>& points_m) {
  if (points_m.size() <= count) return;
  for (std::size_t i = 0; i < count; ++i) {
    std::swap(points_m[i], points_m[i + random.below(points_m.size() - i)]);
  }
  points_m.resize(count);
}

}  // namespace

std::vector<Eigen::Vector3d> AutowareSampler::sample(const Scan& scan, const SensorProfile& sensor,
                                                     double range_m, std::uint64_t seed) {
  in_box_m_.resize(std::max(in_box_m_.size(), scan.points_m.size()));
  std::size_t count = 0;
  for (const Eigen::Vector3d& p_sensor_m : scan.points_m) {
    const Eigen::Vector3d p_vehicle_m = sensor.T_vehicle_lidar * p_sensor_m;
    in_box_m_[count] = p_vehicle_m;  // without a branch: which are inside is as good as random
    const bool is_kept = p_sensor_m.squaredNorm() <= range_m * range_m && is_in_box(p_vehicle_m);
    count += is_kept ? 1 : 0;
  }
  std::vector<Eigen::Vector3d> points_m =
      cutter_.cut(std::span(in_box_m_).first(count), {kBeyondBox_m, kVoxel_m}, 1.0);
  keep_random(kMostPoints, Random(seed), points_m);
  return points_m;
}

}  // namespace sightline
