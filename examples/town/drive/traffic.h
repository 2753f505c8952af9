#pragma once

#include <cstdint>
#include <vector>

#include "examples/town/whole/town.h"

namespace sightline::town {

// Something that moves along the driven line at some lateral of it.
struct Mover {
  enum class Role { kLeader, kFollower, kOncoming, kPedestrian, kLorry };
  Role role = Role::kOncoming;
  double start_m = 0.0;        // arc length at time 0; of leaders and followers: gap to the drive
  double speed_m_s = 0.0;      // along the line, negative against it; of leaders: see active_from_m
  double lateral_m = 0.0;      // + left; of pedestrians: from the kerb outward on that side's sign
  double active_from_m = 0.0;  // leaders and followers: where on the route they are with us
  double active_to_m = 0.0;
  std::uint64_t seed = 0;  // of its shape
};

// Everything that moves during one drive: cars ahead and behind in the same lane for parts of the
// way, oncoming ones, people on the pavements. Each drive meets others. `times` as many as usual:
// gaps are as much shorter. Of a town of streets; others have draw_road_traffic().
std::vector<Mover> draw_traffic(const Town& town, std::uint64_t drive, double duration_s,
                                double times = 1.0);

// From our lane's middle to the oncoming one's.
inline constexpr double kNextLane_m = 3.5;
// True where the street that is driven at an arc length has room for oncoming cars.
bool has_next_lane(const Town& town, double s_m);

// Where the drive itself is at that moment.
struct Moment {
  double time_s = 0.0;
  double driven_m = 0.0;
};

// All that moves and is near the drive at that moment, as triangles.
TownMesh moving_mesh(const Town& town, const std::vector<Mover>& movers, const Moment& moment);

}  // namespace sightline::town
