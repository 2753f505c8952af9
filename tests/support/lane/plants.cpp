#include "tests/support/lane/plants.h"

#include <algorithm>
#include <cmath>

namespace sightline::lane {
namespace {

Eigen::Vector3d random_unit(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

void add_leaf(Mesh& mesh, const Eigen::Vector3d& at_m, double size_m, Kind kind, Random& random) {
  const Eigen::Vector3d u = random_unit(random);
  const Eigen::Vector3d v = u.cross(random_unit(random)).normalized();
  add_triangle(mesh, {at_m + size_m * u, at_m + size_m * v, at_m - size_m * (u + v)}, kind);
}

}  // namespace

void add_tree(Lane& lane, const Eigen::Vector2d& at_m, bool has_leaves, Random& random) {
  constexpr int kBoughs = 34;
  constexpr int kLeavesOfBough = 70;
  const Eigen::Vector3d foot_m(at_m.x(), at_m.y(), lane.ground.height_m(at_m.x(), at_m.y()));
  const double radius_m = random.uniform(1.5, 2.3);
  const Eigen::Vector3d fork_m = foot_m + Eigen::Vector3d(0.0, 0.0, random.uniform(2.2, 2.8));
  const Eigen::Vector3d middle_m = fork_m + Eigen::Vector3d(0.0, 0.0, radius_m);
  add_tube(lane.mesh, {foot_m, fork_m, random.uniform(0.1, 0.2)}, Kind::kTrunk);
  for (int bough = 0; bough < kBoughs; ++bough) {
    const double out = std::cbrt(random.uniform());
    const Eigen::Vector3d at = middle_m + radius_m * out * random_unit(random);
    if (bough % 4 == 0) add_tube(lane.mesh, {fork_m, at, 0.035}, Kind::kTrunk);
    if (!has_leaves) continue;
    lane.leaf_balls.push_back({at, 0.9});
    for (int leaf = 0; leaf < kLeavesOfBough; ++leaf) {
      const Eigen::Vector3d off_m =
          0.28 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
      add_leaf(lane.mesh, at + off_m, 0.06, Kind::kCrown, random);
    }
  }
}

void add_hedge(Lane& lane, const Border& border, Random& random) {
  constexpr double kLeavesPerMetre = 500.0;
  constexpr double kHeight_m = 1.4;
  const double length_m = border.to_y_m - border.from_y_m;
  for (double y_m = border.from_y_m; y_m < border.to_y_m; y_m += 0.7) {
    lane.leaf_balls.push_back(
        {{border.x_m, y_m, lane.ground.height_m(border.x_m, y_m) + 0.7}, 1.1});
  }
  for (double i = 0.0; i < kLeavesPerMetre * length_m; i += 1.0) {
    const double x_m = border.x_m + random.uniform(-0.35, 0.35);
    const double y_m = random.uniform(border.from_y_m, border.to_y_m);
    const double z_m = lane.ground.height_m(x_m, y_m) + random.uniform(0.0, kHeight_m);
    add_leaf(lane.mesh, {x_m, y_m, z_m}, 0.05, Kind::kHedge, random);
  }
}

void add_fence(Lane& lane, const Border& border) {
  constexpr double kPitch_m = 0.22;
  for (double y_m = border.from_y_m; y_m < border.to_y_m; y_m += kPitch_m) {
    const double ground = lane.ground.height_m(border.x_m, y_m);
    add_block(lane.mesh, {{border.x_m, y_m, ground + 0.6}, {0.015, 0.04, 0.6}, 0.0}, Kind::kFence);
  }
  for (const double up_m : {0.3, 1.0}) {
    for (double y_m = border.from_y_m; y_m < border.to_y_m; y_m += 2.2) {
      const double end_m = std::min(y_m + 2.2, border.to_y_m);
      const Eigen::Vector3d from(border.x_m, y_m, lane.ground.height_m(border.x_m, y_m) + up_m);
      const Eigen::Vector3d to(border.x_m, end_m, lane.ground.height_m(border.x_m, end_m) + up_m);
      add_tube(lane.mesh, {from, to, 0.04}, Kind::kFence);
    }
  }
}

}  // namespace sightline::lane
