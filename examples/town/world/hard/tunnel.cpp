#include <algorithm>
#include <array>

#include "examples/town/world/hard/places.h"

namespace sightline::town {
namespace {

constexpr double kWall_m = 3.4;   // height of the upright walls, below the vault
constexpr double kCrown_m = 6.0;  // of the vault
constexpr double kNicheHigh_m = 2.3;
constexpr double kNicheDeep_m = 0.9;
constexpr double kNicheWide_m = 2.4;
constexpr int kLampsPerNiche = 4;

// The tube from the right wall's foot over the vault to the left wall's.
Profile outline(const Tube& tube) {
  const double middle_m = 0.5 * (tube.left_m - tube.right_m);
  const double half_m = 0.5 * (tube.left_m + tube.right_m);
  return {{-tube.right_m, 0.0},
          {-tube.right_m, kWall_m},
          {middle_m - 0.75 * half_m, 4.9},
          {middle_m - 0.3 * half_m, kCrown_m},
          {middle_m + 0.3 * half_m, kCrown_m},
          {middle_m + 0.75 * half_m, 4.9},
          {tube.left_m, kWall_m},
          {tube.left_m, 0.0}};
}

void add_niche(TownMesh& mesh, const Road& road, const Tube& tube, const Stretch& niche) {
  const double wall_m = -tube.right_m;
  const double back_m = wall_m - kNicheDeep_m;
  extrude(mesh, road, niche, {{wall_m, 0.0}, {back_m, 0.0}}, Label::kKerb);
  extrude(mesh, road, niche,
          {{back_m, 0.0}, {back_m, kNicheHigh_m}, {wall_m, kNicheHigh_m}, {wall_m, kWall_m}},
          Label::kFacade);
  for (const double s_m : {niche.from_m, niche.to_m}) {
    add_quad(mesh,
             {road.on(s_m, wall_m, 0.0), road.on(s_m, back_m, 0.0),
              road.on(s_m, back_m, kNicheHigh_m), road.on(s_m, wall_m, kNicheHigh_m)},
             Label::kFacade);
  }
}

// The right wall, with its niches at an exact pitch.
void add_right_wall(TownMesh& mesh, const Road& road, const Tube& tube, const Stretch& stretch) {
  const Profile wall = {{-tube.right_m, 0.0}, {-tube.right_m, kWall_m}};
  double from_m = stretch.from_m;
  std::vector<double> niches;
  if (!is_smooth(road.seed)) niches = evenly(stretch, kLampsPerNiche * tube.pitch_m);
  for (const double s_m : niches) {
    const Stretch niche{s_m - 0.5 * kNicheWide_m, s_m + 0.5 * kNicheWide_m};
    extrude(mesh, road, {from_m, niche.from_m}, wall, Label::kFacade);
    add_niche(mesh, road, tube, niche);
    from_m = niche.to_m;
  }
  extrude(mesh, road, {from_m, stretch.to_m}, wall, Label::kFacade);
}

// The front around an end of the tube.
void add_portal(TownMesh& mesh, const Road& road, const Tube& tube, double s_m) {
  constexpr double kHigh_m = 9.0;
  constexpr double kWide_m = 30.0;
  const Profile tube_outline = outline(tube);
  const auto face = [&](double lateral_a, double up_a, double lateral_b, double up_b) {
    add_quad(mesh,
             {road.on(s_m, lateral_a, up_a), road.on(s_m, lateral_b, up_b),
              road.on(s_m, lateral_b, kHigh_m), road.on(s_m, lateral_a, kHigh_m)},
             Label::kFacade);
  };
  face(-kWide_m, 0.0, -tube.right_m, 0.0);
  face(tube.left_m, 0.0, kWide_m, 0.0);
  for (std::size_t i = 1; i + 2 < tube_outline.size(); ++i) {
    face(tube_outline[i].first, tube_outline[i].second, tube_outline[i + 1].first,
         tube_outline[i + 1].second);
  }
}

void add_lamps(TownMesh& mesh, const Road& road, const Tube& tube, const Stretch& stretch) {
  const double middle_m = 0.5 * (tube.left_m - tube.right_m);
  const double off_m = 0.2 * (tube.left_m + tube.right_m);
  if (is_smooth(road.seed)) return;
  for (const double s_m : evenly(stretch, tube.pitch_m)) {
    for (const double side : {1.0, -1.0}) {
      add_road_box(mesh, road, {s_m, middle_m + side * off_m}, {1.2, 0.35, 5.1, 5.25},
                   Label::kPole);
    }
  }
}

}  // namespace

Tube tube_of(std::uint64_t seed, const Place& place) {
  Random random(mix(mix(seed, 0x74756265ULL), static_cast<std::uint64_t>(place.from_m + 1000.0)));
  Tube tube;
  tube.left_m = random.uniform(5.2, 6.4);
  tube.right_m = random.uniform(3.6, 4.6);
  tube.pitch_m = random.uniform(10.0, 14.0);
  return tube;
}

void add_tunnel(TownMesh& mesh, const Road& road, const Place& place, Random /*random*/) {
  const Tube tube = tube_of(road.seed, place);
  const Stretch stretch{place.from_m, place.to_m};
  Profile vault = outline(tube);
  vault.erase(vault.begin());
  extrude(mesh, road, stretch, vault, Label::kFacade);
  add_right_wall(mesh, road, tube, stretch);
  add_lamps(mesh, road, tube, stretch);
  for (const double side : {1.0, -1.0}) {
    const double wall_m = side > 0.0 ? tube.left_m : -tube.right_m;
    const double edge_m = wall_m - 0.7 * side;
    extrude(mesh, road, stretch, {{edge_m, 0.0}, {edge_m, 0.2}, {wall_m, 0.2}}, Label::kKerb);
  }
  for (const double s_m : {place.from_m, place.to_m}) add_portal(mesh, road, tube, s_m);
}

}  // namespace sightline::town
