#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "formats/base/random.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/matcher.h"

// A room to match in: a floor and four walls with a dent, measured with noise, and the map of it.

namespace sightline {

inline Eigen::Vector3d random_vector(Random& random, double low, double high) {
  const double x = random.uniform(low, high);
  const double y = random.uniform(low, high);
  return {x, y, random.uniform(low, high)};
}

// Points of a room of about 23 x 15 x 6 m about the origin. No wall lies on a face of a cell.
inline std::vector<Eigen::Vector3d> room_points(std::uint64_t seed, std::size_t count,
                                                double noise_m) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  while (points_m.size() < count) {
    const double x = random.uniform(-12.0, 12.0);
    const double y = random.uniform(-8.0, 8.0);
    const double z = random.uniform(-2.0, 4.0);
    Eigen::Vector3d point(x, y, -2.0 + 0.02 * x);
    const std::uint64_t side = random.below(8);
    if (side == 0) point = {-11.3, y, z};
    if (side == 1) point = {11.7 + 0.1 * y, y, z};
    if (side == 2) point = {x, -7.1 + (std::abs(x) < 2.0 ? 1.0 : 0.0), z};
    if (side == 3) point = {x, 7.4, z};
    point += noise_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    points_m.push_back(point);
  }
  return points_m;
}

inline NdtMap simple_map(const std::vector<Eigen::Vector3d>& points_m, double cell_m) {
  std::map<CellKey, std::vector<Eigen::Vector3d>> cells;
  for (const Eigen::Vector3d& point_m : points_m)
    cells[cell_key(point_m, cell_m)].push_back(point_m);
  std::map<std::pair<TileKey, CellKey>, Nd> nds;
  NdtMap map;
  map.cell_m = cell_m;
  for (const auto& [key, members_m] : cells) {
    if (members_m.size() < 10) continue;
    Nd nd;
    nd.key = key;
    nd.point_count = static_cast<std::uint32_t>(members_m.size());
    for (const Eigen::Vector3d& point_m : members_m) nd.mean_m += point_m;
    nd.mean_m /= nd.point_count;
    for (const Eigen::Vector3d& point_m : members_m) {
      const Eigen::Vector3d off_m = point_m - nd.mean_m;
      nd.covariance_m2 += off_m * off_m.transpose() / (nd.point_count - 1.0);
    }
    decompose(nd);
    nds[{tile_of(key, cell_m, map.tile_m), key}] = nd;
  }
  for (const auto& [order, nd] : nds) map.nds.push_back(nd);
  return map;
}

inline const NdtMap& room_map() {
  static const NdtMap kMap = simple_map(room_points(21, 30000, 0.02), 1.0);
  return kMap;
}

inline bool is_finite(const MatchResult& result) {
  return result.T_map_sensor.matrix().allFinite() && std::isfinite(result.score) &&
         std::isfinite(result.nearest_voxel_likelihood) && result.hessian.allFinite();
}

inline Pose random_pose(Random& random, double reach_m, double turn_rad) {
  Pose pose = Pose::Identity();
  const Eigen::Vector3d axis = random_vector(random, -1.0, 1.0).normalized();
  pose.linear() = Eigen::AngleAxisd(random.uniform(-turn_rad, turn_rad), axis).toRotationMatrix();
  pose.translation() = random_vector(random, -reach_m, reach_m);
  return pose;
}

inline std::vector<Eigen::Vector3d> transformed(const Pose& pose,
                                                const std::vector<Eigen::Vector3d>& points_m) {
  std::vector<Eigen::Vector3d> result_m;
  for (const Eigen::Vector3d& point_m : points_m) result_m.push_back(pose * point_m);
  return result_m;
}

// A lane of smooth walls 6 m apart, along x, with pilasters of 0.4 m at places drawn once: seen
// from inside, the score has an optimum wherever some of them meet others.
inline std::vector<Eigen::Vector3d> lane_points(std::uint64_t seed, double reach_m, int count) {
  Random places(17);
  std::vector<double> pilasters_m;
  for (double x_m = -30.0; x_m < 30.0; x_m += places.uniform(0.8, 3.0)) pilasters_m.push_back(x_m);
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < count; ++i) {
    const double x_m = random.uniform(-reach_m, reach_m);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const bool is_pilaster = std::ranges::any_of(
        pilasters_m, [&](double at_m) { return std::abs(x_m + 0.7 * side - at_m) < 0.2; });
    const double wall_m = side * (is_pilaster ? 2.6 : 3.0);
    const Eigen::Vector3d noise_m = 0.02 * random_vector(random, -1.0, 1.0);
    const bool is_ground = i % 5 == 0;
    points_m.push_back(noise_m + (is_ground
                                      ? Eigen::Vector3d(x_m, random.uniform(-3.0, 3.0), -1.7)
                                      : Eigen::Vector3d(x_m, wall_m, random.uniform(-1.7, 3.0))));
  }
  return points_m;
}

}  // namespace sightline
