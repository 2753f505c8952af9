#include "tests/support/lane/roadside.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sightline::lane {
namespace {

constexpr double kStorey_m = 3.0;
constexpr double kPitch_m = 2.4;  // of windows
constexpr double kRecess_m = 0.2;
constexpr double kArchHalf_m = 1.6;
constexpr double kSpring_m = 2.0;  // where the arch begins to bend

struct Front {
  const House& house;
  double foot_m;

  // At a place along the lane and a height above the foot, so far behind the wall.
  [[nodiscard]] Eigen::Vector3d at(double y_m, double up_m, double behind_m) const {
    const double x_m = house.front_m + house.slant * up_m + behind_m;
    return {house.side * x_m, y_m, foot_m + up_m};
  }
  [[nodiscard]] Quad wall(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const {
    return {at(low.x(), low.y(), 0.0), at(high.x(), low.y(), 0.0), at(high.x(), high.y(), 0.0),
            at(low.x(), high.y(), 0.0)};
  }
};

double top_m(const House& house) { return kStorey_m * house.storeys; }

void add_window(Mesh& mesh, const Front& front, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high) {
  const Eigen::Vector2d in_low = low + Eigen::Vector2d(0.55, 0.9);
  const Eigen::Vector2d in_high = high - Eigen::Vector2d(0.55, 0.6);
  add_quad(mesh, front.wall(low, {high.x(), in_low.y()}), Kind::kWall);
  add_quad(mesh, front.wall({low.x(), in_high.y()}, high), Kind::kWall);
  add_quad(mesh, front.wall({low.x(), in_low.y()}, {in_low.x(), in_high.y()}), Kind::kWall);
  add_quad(mesh, front.wall({in_high.x(), in_low.y()}, {high.x(), in_high.y()}), Kind::kWall);
  const std::array<Eigen::Vector2d, 4> around = {in_low, Eigen::Vector2d(in_high.x(), in_low.y()),
                                                 in_high, Eigen::Vector2d(in_low.x(), in_high.y())};
  Quad pane_m;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& a = around[i];
    const Eigen::Vector2d& b = around[(i + 1) % 4];
    pane_m[i] = front.at(a.x(), a.y(), kRecess_m);
    add_quad(mesh,
             {front.at(a.x(), a.y(), 0.0), front.at(b.x(), b.y(), 0.0),
              front.at(b.x(), b.y(), kRecess_m), front.at(a.x(), a.y(), kRecess_m)},
             Kind::kWall);
  }
  add_quad(mesh, pane_m, Kind::kWindow);
}

void add_arch(Mesh& mesh, const Front& front) {
  constexpr int kSteps = 10;
  const House& house = front.house;
  const double middle_m = 0.5 * (house.from_y_m + house.to_y_m);
  add_quad(mesh, front.wall({house.from_y_m, -1.0}, {middle_m - kArchHalf_m, 4.0}), Kind::kWall);
  add_quad(mesh, front.wall({middle_m + kArchHalf_m, -1.0}, {house.to_y_m, 4.0}), Kind::kWall);
  Eigen::Vector2d last(middle_m - kArchHalf_m, -1.0);
  for (int i = 0; i <= kSteps + 1; ++i) {
    const double angle = std::numbers::pi * std::min(i, kSteps) / kSteps;
    Eigen::Vector2d next(middle_m - kArchHalf_m * std::cos(angle),
                         kSpring_m + kArchHalf_m * std::sin(angle));
    if (i == kSteps + 1) next.y() = -1.0;
    if (i > 0 && i <= kSteps) {
      add_quad(mesh,
               {front.at(last.x(), last.y(), 0.0), front.at(next.x(), next.y(), 0.0),
                front.at(next.x(), 4.0, 0.0), front.at(last.x(), 4.0, 0.0)},
               Kind::kWall);
    }
    add_quad(
        mesh,
        {front.at(last.x(), last.y(), 0.0), front.at(next.x(), next.y(), 0.0),
         front.at(next.x(), next.y(), house.depth_m), front.at(last.x(), last.y(), house.depth_m)},
        Kind::kArch);
    last = next;
  }
}

void add_front(Mesh& mesh, const Front& front) {
  const House& house = front.house;
  if (house.has_arch) add_arch(mesh, front);
  if (!house.has_arch) {
    add_quad(mesh, front.wall({house.from_y_m, -1.0}, {house.to_y_m, 0.0}), Kind::kWall);
  }
  const double bays = std::floor((house.to_y_m - house.from_y_m) / kPitch_m);
  const double pitch_m = (house.to_y_m - house.from_y_m) / bays;
  const double first_up_m = house.has_arch ? 4.0 : 0.0;
  const double storeys = house.has_arch ? house.storeys - 1.0 : house.storeys;
  const double storey_m = (top_m(house) - first_up_m) / storeys;
  for (double bay = 0.0; bay < bays; bay += 1.0) {
    for (double storey = 0.0; storey < storeys; storey += 1.0) {
      add_window(mesh, front, {house.from_y_m + bay * pitch_m, first_up_m + storey * storey_m},
                 {house.from_y_m + (bay + 1.0) * pitch_m, first_up_m + (storey + 1.0) * storey_m});
    }
  }
}

void add_roof(Mesh& mesh, const Front& front) {
  constexpr double kEaves_m = 0.6;
  constexpr double kDrop_m = 0.3;
  const House& house = front.house;
  const double up_m = top_m(house);
  const double low_y = house.from_y_m - 0.3;
  const double high_y = house.to_y_m + 0.3;
  const double ridge_m = 0.5 * house.depth_m;
  for (const double eaves_m : {-kEaves_m, house.depth_m + kEaves_m}) {
    add_quad(mesh,
             {front.at(low_y, up_m - kDrop_m, eaves_m), front.at(high_y, up_m - kDrop_m, eaves_m),
              front.at(high_y, up_m + 2.2, ridge_m), front.at(low_y, up_m + 2.2, ridge_m)},
             Kind::kRoof);
  }
}

Eigen::Vector3d random_unit(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

void add_leaf(Mesh& mesh, const Eigen::Vector3d& at_m, double size_m, Kind kind, Random& random) {
  const Eigen::Vector3d u = random_unit(random);
  const Eigen::Vector3d v = u.cross(random_unit(random)).normalized();
  add_triangle(mesh, {at_m + size_m * u, at_m + size_m * v, at_m - size_m * (u + v)}, kind);
}

}  // namespace

House draw_house(double side, double from_y_m, Random& random) {
  House house;
  house.side = side;
  house.from_y_m = from_y_m;
  house.to_y_m = from_y_m + random.uniform(8.0, 18.0);
  house.front_m = random.uniform(6.0, 12.0);
  house.depth_m = random.uniform(7.0, 12.0);
  house.storeys = 1.0 + static_cast<double>(random.below(4));
  house.slant = random.uniform(-0.04, 0.09);
  house.has_arch = house.storeys > 1.0 && random.uniform() < 0.3;
  return house;
}

void add_house(Mesh& mesh, const House& house, double foot_m) {
  const Front front{house, foot_m};
  add_front(mesh, front);
  add_roof(mesh, front);
  const double up_m = top_m(house);
  for (const double y_m : {house.from_y_m, house.to_y_m}) {
    add_quad(mesh,
             {front.at(y_m, -1.0, 0.0), front.at(y_m, -1.0, house.depth_m),
              front.at(y_m, up_m, house.depth_m), front.at(y_m, up_m, 0.0)},
             Kind::kWall);
    add_triangle(mesh,
                 {front.at(y_m, up_m, 0.0), front.at(y_m, up_m, house.depth_m),
                  front.at(y_m, up_m + 2.2, 0.5 * house.depth_m)},
                 Kind::kWall);
  }
  const double back_low_m = house.has_arch ? 4.0 : -1.0;
  add_quad(
      mesh,
      {front.at(house.from_y_m, back_low_m, house.depth_m),
       front.at(house.to_y_m, back_low_m, house.depth_m),
       front.at(house.to_y_m, up_m, house.depth_m), front.at(house.from_y_m, up_m, house.depth_m)},
      Kind::kWall);
}

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
