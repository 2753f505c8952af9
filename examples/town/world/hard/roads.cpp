// Roads whose sides look the same every few metres.

#include "examples/town/world/hard/places.h"

namespace sightline::town {
namespace {

// A wall of concrete, narrower above.
void add_concrete_wall(TownMesh& mesh, const Road& road, const Stretch& stretch, double lateral_m) {
  extrude(mesh, road, stretch,
          {{lateral_m - 0.3, 0.0},
           {lateral_m - 0.1, 0.35},
           {lateral_m - 0.08, 0.9},
           {lateral_m + 0.08, 0.9},
           {lateral_m + 0.1, 0.35},
           {lateral_m + 0.3, 0.0}},
          Label::kFacade);
}

// A steel beam on posts at an exact pitch; a wall in a smooth world.
void add_guard_rail(TownMesh& mesh, const Road& road, const Stretch& stretch, double lateral_m,
                    double pitch_m) {
  if (is_smooth(road.seed)) return add_concrete_wall(mesh, road, stretch, lateral_m);
  extrude_bar(mesh, road, stretch,
              {{lateral_m - 0.06, 0.45},
               {lateral_m + 0.06, 0.45},
               {lateral_m + 0.06, 0.76},
               {lateral_m - 0.06, 0.76}},
              Label::kPole);
  for (const double s_m : evenly(stretch, pitch_m)) {
    add_road_pole(mesh, road, {s_m, lateral_m}, 0.06, 0.7);
  }
}

// Posts of 1 m that show where the road's edge is.
void add_delineators(TownMesh& mesh, const Road& road, const Stretch& stretch, double lateral_m) {
  constexpr double kPitch_m = 50.0;
  if (is_smooth(road.seed)) return;
  for (const double s_m : evenly(stretch, kPitch_m)) {
    add_road_box(mesh, road, {s_m, lateral_m}, {0.12, 0.12, 0.0, 1.0}, Label::kPole);
  }
}

// Panels between pillars at an exact pitch. Its face towards the road is at the lateral.
void add_barrier(TownMesh& mesh, const Road& road, const Stretch& stretch, double lateral_m,
                 double top_m) {
  constexpr double kPitch_m = 4.0;
  const double back_m = lateral_m + (lateral_m > 0.0 ? 0.15 : -0.15);
  extrude(mesh, road, stretch,
          {{lateral_m, -0.2}, {lateral_m, top_m}, {back_m, top_m}, {back_m, -0.2}}, Label::kFacade);
  if (is_smooth(road.seed)) return;
  for (const double s_m : evenly(stretch, kPitch_m)) {
    add_road_box(mesh, road, {s_m, lateral_m}, {0.16, 0.2, -0.2, top_m}, Label::kPole);
  }
}

// A railing of posts and two bars; a parapet in a smooth world.
void add_railing(TownMesh& mesh, const Road& road, const Stretch& stretch, double lateral_m) {
  constexpr double kPitch_m = 2.0;
  if (is_smooth(road.seed)) {
    return extrude_bar(mesh, road, stretch,
                       {{lateral_m - 0.1, 0.0},
                        {lateral_m - 0.1, 1.0},
                        {lateral_m + 0.1, 1.0},
                        {lateral_m + 0.1, 0.0}},
                       Label::kFacade);
  }
  for (const double up_m : {0.55, 1.05}) {
    extrude_bar(mesh, road, stretch,
                {{lateral_m - 0.03, up_m},
                 {lateral_m + 0.03, up_m},
                 {lateral_m + 0.03, up_m + 0.06},
                 {lateral_m - 0.03, up_m + 0.06}},
                Label::kPole);
  }
  for (const double s_m : evenly(stretch, kPitch_m)) {
    add_road_pole(mesh, road, {s_m, lateral_m}, 0.04, 1.1);
  }
}

}  // namespace

void add_motorway(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  const Stretch stretch{place.from_m, place.to_m};
  const double pitch_m = random.uniform() < 0.5 ? 2.0 : 4.0;
  const double median_m = random.uniform(5.5, 7.0);
  add_guard_rail(mesh, road, stretch, -random.uniform(7.0, 8.5), pitch_m);
  add_guard_rail(mesh, road, stretch, median_m, pitch_m);
  add_guard_rail(mesh, road, stretch, median_m + 1.2, pitch_m);
  add_guard_rail(mesh, road, stretch, median_m + 14.0, pitch_m);
  add_delineators(mesh, road, stretch, -9.5);
}

void add_noise_barrier(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  const Stretch stretch{place.from_m, place.to_m};
  const double left_m = random.uniform(8.0, 12.0);
  const double right_m = random.uniform(5.5, 9.0);
  const double top_m = random.uniform(3.5, 5.0);
  add_barrier(mesh, road, stretch, left_m, top_m);
  add_barrier(mesh, road, stretch, -right_m, top_m);
  add_guard_rail(mesh, road, stretch, -right_m + 0.9, 4.0);
}

void add_bridge(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  const Stretch stretch{place.from_m, place.to_m};
  const double kerb_m = random.uniform(0.08, 0.15);
  for (const double side : {1.0, -1.0}) {
    const double edge_m = side > 0.0 ? kDeckLeft_m : -kDeckRight_m;
    const double kerb_at_m = edge_m - 1.2 * side;
    extrude(mesh, road, stretch,
            {{kerb_at_m, 0.0}, {kerb_at_m, kerb_m}, {edge_m, kerb_m}, {edge_m, -1.5}},
            Label::kKerb);
    add_railing(mesh, road, stretch, edge_m - 0.25 * side);
  }
}

}  // namespace sightline::town
