// Places without walls.

#include <algorithm>
#include <array>
#include <cmath>

#include "examples/town/world/furniture.h"
#include "examples/town/world/hard/places.h"

namespace sightline::town {
namespace {

// A tree of town furniture on the ground of the road.
void add_road_tree(TownMesh& mesh, const Road& road, const Placement& at, std::uint64_t seed) {
  const Eigen::Vector3d base_m = road.on(at.s_m, at.lateral_m, 0.0);
  TownMesh tree;
  add_tree(tree, base_m.head<2>(), seed);
  for (Eigen::Vector3f& vertex : tree.vertices_m) vertex.z() += static_cast<float>(base_m.z());
  append(mesh, tree);
}

// A trunk of a wood, with twigs of its own above and now and then some at its foot.
void add_trunk(TownMesh& mesh, const Road& road, const Placement& at, Random& random) {
  constexpr int kTwigs = 24;
  const double radius_m = random.uniform(0.09, 0.28);
  const double top_m = random.uniform(11.0, 18.0);
  const bool has_bush = random.uniform() < 0.3;
  add_road_pole(mesh, road, at, radius_m, top_m, Label::kTrunk);
  for (int twig = 0; twig < kTwigs; ++twig) {
    const bool is_low = has_bush && twig % 2 == 0;
    const double up_m = is_low ? random.uniform(0.1, 1.2) : random.uniform(3.5, top_m);
    std::array<double, 2> off_m{};
    for (double& axis : off_m) axis = random.uniform(-1.5, 1.5);
    const Eigen::Vector3d middle =
        road.on(at.s_m, at.lateral_m, up_m) + Eigen::Vector3d(off_m[0], off_m[1], 0.0);
    std::array<Eigen::Vector3d, 3> corners;
    for (Eigen::Vector3d& corner : corners) {
      for (int axis = 0; axis < 3; ++axis) {
        corner[axis] = middle[axis] + random.uniform(-0.4, 0.4);
      }
    }
    add_triangle(mesh, corners, Label::kCrown);
  }
}

double random_side(Random& random) { return random.uniform() < 0.5 ? 1.0 : -1.0; }

}  // namespace

void add_field(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  constexpr double kPitch_m = 40.0;
  const double lateral_m = random_side(random) * random.uniform(5.0, 8.0);
  const double first_m = place.from_m + random.uniform(10.0, 30.0);
  for (double s_m = first_m; s_m < place.to_m; s_m += kPitch_m) {
    add_road_pole(mesh, road, {s_m, lateral_m}, 0.14, 8.0);
  }
}

void add_forest(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  constexpr double kEdge_m = 4.5;  // from the line to the first trunks
  constexpr double kReach_m = 40.0;
  constexpr double kPerMetre = 2.6;  // trunks for each metre of road, on both sides together
  const auto count = static_cast<int>(kPerMetre * place.length_m());
  for (int i = 0; i < count; ++i) {
    const double s_m = random.uniform(place.from_m, place.to_m);
    const double side = random_side(random);
    // Denser near the road, where they are seen.
    const double away = random.uniform();
    const double lateral_m = side * (kEdge_m + kReach_m * away * std::sqrt(away));
    add_trunk(mesh, road, {s_m, lateral_m}, random);
  }
}

void add_plaza(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  constexpr double kPitch_m = 30.0;  // of poles and of benches, along the road
  constexpr double kClear_m = 9.0;
  constexpr double kReach_m = 40.0;
  const auto count = std::max(1, static_cast<int>(place.length_m() / kPitch_m));
  for (int i = 0; i < count; ++i) {
    const double from_m = place.from_m + place.length_m() * i / count;
    const double to_m = place.from_m + place.length_m() * (i + 1) / count;
    for (const bool is_pole : {true, false}) {
      const double s_m = random.uniform(from_m, to_m);
      const double side = random_side(random);
      const double lateral_m = side * random.uniform(kClear_m, kReach_m);
      if (is_pole) {
        add_road_pole(mesh, road, {s_m, lateral_m}, 0.08, 6.0);
      } else {
        add_road_box(mesh, road, {s_m, lateral_m}, {1.8, 0.5, -0.1, 0.45}, Label::kClutter);
      }
    }
  }
}

void add_hills(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  constexpr double kPosts_m = 50.0;
  constexpr double kTrees_m = 25.0;
  const Stretch stretch{place.from_m, place.to_m};
  for (const double s_m : evenly(stretch, kPosts_m)) {
    for (const double lateral_m : {-4.5, 6.5}) {
      add_road_box(mesh, road, {s_m, lateral_m}, {0.12, 0.12, 0.0, 1.0}, Label::kPole);
    }
  }
  for (double s_m = place.from_m + random.uniform(0.0, kTrees_m); s_m < place.to_m;
       s_m += kTrees_m * random.uniform(0.6, 1.4)) {
    const double side = random_side(random);
    const double lateral_m = side * random.uniform(8.0, 25.0);
    add_road_tree(mesh, road, {s_m, lateral_m}, random.next());
  }
}

}  // namespace sightline::town
