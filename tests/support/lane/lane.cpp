#include "tests/support/lane/lane.h"

#include <cmath>

#include "formats/base/random.h"
#include "tests/support/lane/houses.h"
#include "tests/support/lane/plants.h"

namespace sightline::lane {
namespace {

constexpr double kBeyond_m = 70.0;  // what is seen from the ends of the drive
constexpr double kCrossing_m = 14.0;

double line_x_m(double y_m) { return 1.5 * std::sin(y_m / 25.0); }

void add_ground(Lane& lane, double length_m) {
  const auto corner = [&](int x, int y) {
    return Eigen::Vector3d(x, y, lane.ground.height_m(x, y));
  };
  const int end = static_cast<int>(length_m + kBeyond_m);
  for (int x = -80; x < 80; ++x) {
    for (int y = -static_cast<int>(kBeyond_m); y < end; ++y) {
      add_quad(lane.mesh, {corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)},
               Kind::kGround);
    }
  }
}

void add_car(Lane& lane, const Eigen::Vector2d& at_m, Random& random) {
  const double yaw_rad = 1.5707 + random.uniform(-0.05, 0.05);
  const double ground = lane.ground.height_m(at_m.x(), at_m.y());
  const double length_m = random.uniform(1.9, 2.4);
  add_rounded(lane.mesh, {{at_m.x(), at_m.y(), ground + 0.62}, {length_m, 0.88, 0.42}, yaw_rad},
              0.35, Kind::kCar);
  add_rounded(lane.mesh,
              {{at_m.x(), at_m.y() - 0.2, ground + 1.05}, {0.6 * length_m, 0.75, 0.45}, yaw_rad},
              0.6, Kind::kCar);
}

void add_sign(Lane& lane, const Eigen::Vector2d& at_m, Random& random) {
  const double ground = lane.ground.height_m(at_m.x(), at_m.y());
  const Eigen::Vector3d foot_m(at_m.x(), at_m.y(), ground);
  add_tube(lane.mesh, {foot_m, foot_m + Eigen::Vector3d(0.0, 0.0, 2.8), 0.03}, Kind::kPole);
  add_block(
      lane.mesh,
      {foot_m + Eigen::Vector3d(0.0, -0.05, 2.5), {0.3, 0.01, 0.3}, random.uniform(-0.4, 0.4)},
      Kind::kSign);
}

void add_lamp(Lane& lane, const Eigen::Vector2d& at_m, double towards) {
  const Eigen::Vector3d foot_m(at_m.x(), at_m.y(), lane.ground.height_m(at_m.x(), at_m.y()));
  const Eigen::Vector3d top_m = foot_m + Eigen::Vector3d(0.0, 0.0, 6.5);
  add_tube(lane.mesh, {foot_m, top_m, 0.07}, Kind::kPole);
  add_tube(lane.mesh, {top_m, top_m + Eigen::Vector3d(1.5 * towards, 0.0, 0.2), 0.04}, Kind::kPole);
}

// Between kerb and houses of one side.
void add_furniture(Lane& lane, double side, const LaneOptions& options, Random& random) {
  double y_m = -30.0 + random.uniform(0.0, 5.0);
  while (y_m < options.length_m + 30.0) {
    const double kerb_m = line_x_m(y_m) + side * 3.6;
    const double what = random.uniform();
    if (what < 0.40) add_car(lane, {kerb_m, y_m}, random);
    if (what >= 0.40 && what < 0.55) add_sign(lane, {kerb_m + 0.8 * side, y_m}, random);
    if (what >= 0.55 && what < 0.70) add_lamp(lane, {kerb_m + 0.9 * side, y_m}, -side);
    if (what >= 0.70) {
      const Eigen::Vector2d at_m(kerb_m + 1.3 * side, y_m);
      add_tree(lane, at_m, options.has_leaves, random);
    }
    y_m += random.uniform(4.5, 8.0);
  }
}

// Houses of one side, with gardens before those that stand back.
void add_row(Lane& lane, double side, const LaneOptions& options, Random& random) {
  const double crossing_m = 0.6 * options.length_m;
  double y_m = -60.0;
  while (y_m < options.length_m + 60.0) {
    House house = draw_house(side, y_m, random);
    const bool is_crossing = house.to_y_m > crossing_m && house.from_y_m < crossing_m + kCrossing_m;
    y_m = is_crossing ? crossing_m + kCrossing_m : house.to_y_m + random.uniform(0.5, 6.0);
    if (is_crossing) continue;
    const double middle_m = 0.5 * (house.from_y_m + house.to_y_m);
    add_house(lane.mesh, house, lane.ground.height_m(side * house.front_m, middle_m));
    if (house.front_m < 8.0) continue;
    const Border border{side * (house.front_m - 2.5), house.from_y_m, house.to_y_m};
    if (random.uniform() < 0.5) {
      add_fence(lane, border);
    } else if (options.has_leaves) {
      add_hedge(lane, border, random);
    }
  }
}

// Plain walls behind the rows, here and there.
void add_background(Lane& lane, double side, double length_m, Random& random) {
  for (double y_m = -60.0; y_m < length_m + 60.0; y_m += random.uniform(14.0, 30.0)) {
    const double half_m = random.uniform(3.0, 9.0);
    const double x_m = side * random.uniform(32.0, 55.0);
    const double height_m = random.uniform(3.0, 9.0);
    add_block(lane.mesh,
              {{x_m, y_m, lane.ground.height_m(x_m, y_m) + 0.5 * height_m - 1.0},
               {half_m, 0.7 * half_m, 0.5 * height_m + 1.0},
               random.uniform(-0.6, 0.6)},
              Kind::kWall);
  }
}

}  // namespace

double Ground::height_m(double x_m, double y_m) const {
  const double waves_m = 0.5 * std::sin(y_m / 19.0 + 0.3) + 0.2 * std::sin(x_m / 9.0 + y_m / 31.0) +
                         0.05 * std::sin(x_m / 2.1) * std::sin(y_m / 2.7);
  return 50.0 + hills * waves_m;
}

Pose sensor_pose(const Ground& ground, double way_m) {
  constexpr double kAhead_m = 1.5;
  const auto on_line = [&](double y_m) {
    return Eigen::Vector3d(line_x_m(y_m), y_m, ground.height_m(line_x_m(y_m), y_m) + 2.0);
  };
  const Eigen::Vector3d forward =
      (on_line(way_m + kAhead_m) - on_line(way_m - kAhead_m)).normalized();
  const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(forward).normalized();
  Pose pose = Pose::Identity();
  pose.linear() << forward, left, forward.cross(left);
  pose.translation() = on_line(way_m);
  return pose;
}

Lane make_lane(const LaneOptions& options) {
  Lane lane;
  lane.ground.hills = options.hills;
  add_ground(lane, options.length_m);
  for (const double side : {-1.0, 1.0}) {
    Random random(mix(options.seed, side > 0.0 ? 2 : 1));
    add_row(lane, side, options, random);
    add_background(lane, side, options.length_m, random);
    Random furniture(mix(options.seed, side > 0.0 ? 4 : 3));
    add_furniture(lane, side, options, furniture);
  }
  return lane;
}

}  // namespace sightline::lane
