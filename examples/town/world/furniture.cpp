#include "examples/town/world/furniture.h"

#include <algorithm>

#include "formats/base/random.h"

namespace sightline::town {
namespace {

constexpr double kBuriedM = -0.15;  // things begin below the uneven ground

bool is_free_of_roads(const TownPlan& plan, const Eigen::Vector2d& point_m) {
  // On a plaza the whole corridor is roadway; what stands there keeps away from the driven line.
  return std::none_of(plan.streets.begin(), plan.streets.end(), [&](const Street& street) {
    return street.kind != StreetKind::kPlaza && contains(roadway(street), point_m);
  });
}

void add_pole(TownMesh& mesh, const Eigen::Vector2d& at_m, Random& random) {
  const bool is_lamp = random.uniform() < 0.6;
  const double top_m = is_lamp ? random.uniform(5.0, 8.0) : random.uniform(2.4, 3.2);
  add_prism(mesh, {at_m, is_lamp ? random.uniform(0.07, 0.11) : 0.04, kBuriedM, top_m, 8},
            Label::kPole);
  if (is_lamp) return;
  Box plate{at_m, random.uniform(0.0, std::numbers::pi), 0.6, 0.03, top_m - 0.7, top_m};
  add_box(mesh, plate, Label::kPole);
}

// Things in a line along one side of a street, about `pitch_m` apart.
template <class Add>
void line_up(const TownPlan& plan, const Street& street, double lateral_m, double pitch_m,
             Random& random, const Add& add) {
  for (double along_m = random.uniform(0.0, pitch_m); along_m < street.length_m;
       along_m += pitch_m * random.uniform(0.8, 1.2)) {
    const Eigen::Vector2d at_m = street.at(along_m, lateral_m);
    if (is_free_of_roads(plan, at_m)) add(at_m);
  }
}

struct FurnitureStyle {
  double pole_pitch_m = 30.0;
  double tree_pitch_m = 0.0;  // 0: no trees
};

FurnitureStyle furniture_style(StreetKind kind, Random& random) {
  switch (kind) {
    case StreetKind::kCanyon:
      return {random.uniform(22.0, 36.0), random.uniform() < 0.3 ? random.uniform(12, 20) : 0.0};
    case StreetKind::kAvenue:
      return {random.uniform(24.0, 34.0), random.uniform(8.0, 12.0)};
    case StreetKind::kSmooth:
    case StreetKind::kRepeating:
      return {random.uniform(36.0, 50.0), 0.0};
    case StreetKind::kSide:
      return {random.uniform(25.0, 40.0), random.uniform(14.0, 30.0)};
    case StreetKind::kLane:
    case StreetKind::kPlaza:
      break;
  }
  return {0.0, 0.0};
}

void furnish_street(TownMesh& mesh, const TownPlan& plan, const Street& street, Random& random) {
  const FurnitureStyle style = furniture_style(street.kind, random);
  constexpr double kBehindKerbM = 0.5;
  const auto tree = [&](const Eigen::Vector2d& at_m) { add_tree(mesh, at_m, random.next()); };
  const auto pole = [&](const Eigen::Vector2d& at_m) { add_pole(mesh, at_m, random); };
  for (const double side : {1.0, -1.0}) {
    const double kerb_m = side > 0.0 ? street.kerb_left_m : street.kerb_right_m;
    const double lateral_m = side * (kerb_m + kBehindKerbM);
    if (style.pole_pitch_m > 0.0) {
      line_up(plan, street, lateral_m, style.pole_pitch_m, random, pole);
    }
    if (style.tree_pitch_m > 0.0) {
      line_up(plan, street, lateral_m + side * 0.6, style.tree_pitch_m, random, tree);
    }
  }
}

// A plaza is open: a few lamps and trees far apart, kiosks and a monument.
void furnish_plaza(TownMesh& mesh, const TownPlan& plan, const Street& street, Random& random) {
  constexpr double kClearOfLineM = 9.0;
  const auto count = static_cast<int>(6 + random.below(8));
  for (int i = 0; i < count; ++i) {
    const double side = random.uniform() < 0.5 ? 1.0 : -1.0;
    const double reach_m = (side > 0.0 ? street.left_m : street.right_m) - 4.0;
    const Eigen::Vector2d at_m = street.at(random.uniform(4.0, street.length_m - 4.0),
                                           side * random.uniform(kClearOfLineM, reach_m));
    const double what = random.uniform();
    const double yaw_rad = random.uniform(0.0, std::numbers::pi);
    const double size_m = random.uniform(1.5, 3.5);
    if (!is_free_of_roads(plan, at_m)) continue;
    if (what < 0.4) {
      add_pole(mesh, at_m, random);
    } else if (what < 0.75) {
      add_tree(mesh, at_m, random.next());
    } else {
      add_box(mesh, {at_m, yaw_rad, size_m, 0.7 * size_m, kBuriedM, random.uniform(1.0, 3.0)},
              Label::kClutter);
    }
  }
}

bool is_on_other_street(const TownPlan& plan, const Street& street,
                        const Eigen::Vector2d& point_m) {
  return std::any_of(plan.streets.begin(), plan.streets.end(), [&](const Street& other) {
    return &other != &street && contains(corridor(other), point_m);
  });
}

bool has_parking(StreetKind kind) {
  return kind == StreetKind::kCanyon || kind == StreetKind::kAvenue || kind == StreetKind::kSide;
}

}  // namespace

void add_tree(TownMesh& mesh, const Eigen::Vector2d& at_m, std::uint64_t seed) {
  Random random(seed);
  const double crown_m = random.uniform(2.6, 3.6);  // where the crown begins
  const double radius_m = random.uniform(1.3, 2.4);
  const double half_height_m = random.uniform(1.3, 2.2);
  const Eigen::Vector3d centre_m(at_m.x(), at_m.y(), crown_m + half_height_m);
  add_prism(mesh, {at_m, random.uniform(0.10, 0.22), kBuriedM, crown_m + half_height_m, 8},
            Label::kTrunk);
  const auto in_cube = [&]() -> Eigen::Vector3d {
    const double x = random.uniform(-1.0, 1.0);
    const double y = random.uniform(-1.0, 1.0);
    return Eigen::Vector3d(x, y, random.uniform(-1.0, 1.0));
  };
  constexpr int kLeaves = 260;    // let about half of the rays through
  constexpr double kLeafM = 0.3;  // a twig's leaves together
  for (int leaf = 0; leaf < kLeaves; ++leaf) {
    Eigen::Vector3d offset = in_cube();
    while (offset.squaredNorm() > 1.0) offset = in_cube();
    const Eigen::Vector3d middle =
        centre_m + Eigen::Vector3d(radius_m, radius_m, half_height_m).cwiseProduct(offset);
    std::array<Eigen::Vector3d, 3> corners;
    for (Eigen::Vector3d& corner : corners) corner = middle + kLeafM * in_cube();
    add_triangle(mesh, corners, Label::kCrown);
  }
}

void add_vehicle(TownMesh& mesh, const Pose2d& pose, double ground_m, std::uint64_t seed,
                 Label label) {
  Random random(seed);
  const Vehicle kind = random.uniform() < 0.15 ? Vehicle::kVan : Vehicle::kCar;
  const bool is_van = kind == Vehicle::kVan;
  const double length_m = is_van ? random.uniform(4.8, 6.0) : random.uniform(3.7, 4.8);
  const double width_m = is_van ? random.uniform(1.9, 2.1) : random.uniform(1.65, 1.9);
  const double waist_m = is_van ? 2.2 : random.uniform(0.85, 1.0);
  const double clearance_m = 0.2;
  Box body{pose.position_m, pose.yaw_rad,           length_m,
           width_m,         ground_m + clearance_m, ground_m + waist_m};
  add_box(mesh, body, label, is_van ? 0.95 : 0.97);
  for (const double axle_m : {-0.3 * length_m, 0.3 * length_m}) {
    const Eigen::Vector2d at_m = pose.position_m + axle_m * direction(pose.yaw_rad);
    add_box(mesh, {at_m, pose.yaw_rad, 0.6, 0.9 * width_m, ground_m, ground_m + 0.5}, label);
  }
  if (is_van) return;
  const Eigen::Vector2d back = -0.1 * length_m * direction(pose.yaw_rad);
  add_box(mesh,
          {pose.position_m + back, pose.yaw_rad, 0.6 * length_m, 0.9 * width_m, ground_m + waist_m,
           ground_m + waist_m + random.uniform(0.45, 0.65)},
          label, 0.75);
}

void add_pedestrian(TownMesh& mesh, const Pose2d& pose, double ground_m, std::uint64_t seed) {
  Random random(seed);
  const double height_m = random.uniform(1.5, 1.9);
  add_prism(mesh, {pose.position_m, 0.22, ground_m, ground_m + height_m - 0.25, 8},
            Label::kPedestrian);
  add_prism(mesh, {pose.position_m, 0.1, ground_m + height_m - 0.25, ground_m + height_m, 6},
            Label::kPedestrian);
}

void add_board(TownMesh& mesh, const Board& board, double ground_m) {
  constexpr double kThicknessM = 0.03;
  const Eigen::Vector2d& at_m = board.pose.position_m;
  const double bottom_m = ground_m + board.bottom_m;
  add_prism(mesh, {at_m, 0.04, ground_m + kBuriedM, bottom_m, 8}, Label::kPole);
  add_box(mesh,
          {at_m, board.pose.yaw_rad + 0.5 * std::numbers::pi, board.width_m, kThicknessM, bottom_m,
           bottom_m + board.height_m},
          Label::kPole);
}

void add_furniture(TownMesh& mesh, std::uint64_t seed, const TownPlan& plan) {
  for (std::size_t i = 0; i < plan.streets.size(); ++i) {
    Random random(mix(mix(seed, 0x6675726eULL), i));
    const Street& street = plan.streets[i];
    if (street.kind == StreetKind::kPlaza) {
      furnish_plaza(mesh, plan, street, random);
    } else {
      furnish_street(mesh, plan, street, random);
    }
  }
}

std::vector<Pose2d> parked_cars(std::uint64_t seed, const TownPlan& plan) {
  constexpr double kTaken = 0.5;
  constexpr double kFromKerbM = 1.1;
  std::vector<Pose2d> cars;
  Random random(seed);
  for (const Street& street : plan.streets) {
    if (!has_parking(street.kind)) continue;
    // Narrow side streets have cars on one side alone.
    const bool both = street.kind != StreetKind::kSide;
    for (const double side : {1.0, -1.0}) {
      const double kerb_m = side > 0.0 ? street.kerb_left_m : street.kerb_right_m;
      const double yaw_rad = street.heading_rad + (side > 0.0 ? std::numbers::pi : 0.0);
      double along_m = random.uniform(2.5, 9.0);
      for (; along_m < street.length_m - 3.0; along_m += random.uniform(6.2, 8.0)) {
        const double lateral_m = side * (kerb_m - kFromKerbM) + random.uniform(-0.15, 0.15);
        const double turned_rad = random.uniform(-0.03, 0.03);
        const bool is_taken = random.uniform() < kTaken && (both || side < 0.0);
        const Eigen::Vector2d at_m = street.at(along_m, lateral_m);
        if (!is_taken || is_on_other_street(plan, street, at_m)) continue;
        cars.push_back({at_m, yaw_rad + turned_rad});
      }
    }
  }
  return cars;
}

}  // namespace sightline::town
