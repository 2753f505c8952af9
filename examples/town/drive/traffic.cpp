#include "examples/town/drive/traffic.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"

namespace sightline::town {
namespace {

constexpr double kSeenM = 110.0;      // what is farther along the line cannot be seen
constexpr double kNarrowKerbM = 4.5;  // a kerb nearer than this leaves no room for oncoming cars

// How far the drive goes, how long it takes, and how dense the traffic is.
struct Outing {
  double length_m = 0.0;
  double duration_s = 0.0;
  double times = 1.0;
};

void draw_companions(std::vector<Mover>& movers, Mover::Role role, const Outing& outing,
                     Random& random) {
  double from_m = random.uniform(0.0, 60.0);
  while (from_m < outing.length_m) {
    const double to_m = from_m + random.uniform(60.0, 160.0);
    Mover mover;
    mover.role = role;
    mover.start_m =
        role == Mover::Role::kLeader ? random.uniform(11.0, 28.0) : -random.uniform(9.0, 20.0);
    mover.active_from_m = from_m;
    mover.active_to_m = to_m;
    mover.seed = random.next();
    movers.push_back(mover);
    from_m = to_m + random.uniform(40.0, 140.0) / outing.times;
  }
}

void draw_oncoming(std::vector<Mover>& movers, const Outing& outing, Random& random) {
  constexpr double kFastestM_S = 13.0;
  const double farthest_m = outing.length_m + kSeenM + kFastestM_S * outing.duration_s;
  for (double s = random.uniform(20.0, 60.0); s < farthest_m;
       s += random.uniform(30.0, 110.0) / outing.times) {
    Mover mover;
    mover.role = Mover::Role::kOncoming;
    mover.start_m = s;
    // All alike, or they would drive through each other.
    mover.speed_m_s = -10.0;
    mover.lateral_m = kNextLane_m;
    mover.seed = random.next();
    movers.push_back(mover);
  }
}

void draw_pedestrians(std::vector<Mover>& movers, const Outing& outing, Random& random) {
  constexpr double kFastestM_S = 1.7;
  const double reach_m = kSeenM + kFastestM_S * outing.duration_s;
  for (double s = -reach_m; s < outing.length_m + reach_m;
       s += random.uniform(6.0, 30.0) / outing.times) {
    Mover mover;
    mover.role = Mover::Role::kPedestrian;
    mover.start_m = s;
    mover.speed_m_s = random.uniform(0.8, kFastestM_S) * (random.uniform() < 0.5 ? 1.0 : -1.0);
    mover.lateral_m = random.uniform(0.6, 1.6) * (random.uniform() < 0.5 ? 1.0 : -1.0);
    mover.seed = random.next();
    movers.push_back(mover);
  }
}

// A place beside the driven line.
Pose2d beside(const Town& town, double s_m, double lateral_m, bool faces_back) {
  const LinePoint point = town.plan.line.at(s_m);
  return {point.position_m + lateral_m * left_of(direction(point.heading_rad)),
          point.heading_rad + (faces_back ? std::numbers::pi : 0.0)};
}

std::optional<Pose2d> place_companion(const Town& town, const Mover& mover, double driven_m) {
  if (driven_m < mover.active_from_m || driven_m > mover.active_to_m) return std::nullopt;
  // The gap breathes, or the car would leave no trace: seen from here it would stand still.
  const double gap_m = mover.start_m * (1.0 + 0.25 * portable_sin_cos(driven_m / 17.0).sin);
  return beside(town, driven_m + gap_m, 0.0, false);
}

std::optional<Pose2d> place_oncoming(const Town& town, const Mover& mover, const Moment& moment) {
  const double s_m = mover.start_m + mover.speed_m_s * moment.time_s;
  if (std::abs(s_m - moment.driven_m) > kSeenM) return std::nullopt;
  if (!has_next_lane(town, s_m)) return std::nullopt;
  return beside(town, s_m, mover.lateral_m, true);
}

std::optional<Pose2d> place_pedestrian(const Town& town, const Mover& mover, const Moment& moment) {
  const double s_m = mover.start_m + mover.speed_m_s * moment.time_s;
  if (std::abs(s_m - moment.driven_m) > kSeenM) return std::nullopt;
  const Street& street = town.plan.street_at(s_m);
  const double side = mover.lateral_m > 0.0 ? 1.0 : -1.0;
  const double facade_m = side > 0.0 ? street.left_m : street.right_m;
  const double kerb_m = side > 0.0 ? street.kerb_left_m : street.kerb_right_m;
  // Where there is no pavement people keep close to the wall and never walk through one.
  const double away_m = std::min(kerb_m + std::abs(mover.lateral_m), facade_m - 0.5);
  return beside(town, s_m, side * away_m, mover.speed_m_s < 0.0);
}

}  // namespace

bool has_next_lane(const Town& town, double s_m) {
  if (town.is_hard()) return false;
  return town.plan.street_at(s_m).kerb_left_m >= kNarrowKerbM + 1.0;
}

std::vector<Mover> draw_traffic(const Town& town, std::uint64_t drive, double duration_s,
                                double times) {
  Random random(mix(mix(town.options.seed, 0x7472616bULL), drive));
  std::vector<Mover> movers;
  const Outing outing{town.options.length_m, duration_s, times};
  draw_companions(movers, Mover::Role::kLeader, outing, random);
  draw_companions(movers, Mover::Role::kFollower, outing, random);
  draw_oncoming(movers, outing, random);
  draw_pedestrians(movers, outing, random);
  return movers;
}

TownMesh moving_mesh(const Town& town, const std::vector<Mover>& movers, const Moment& moment) {
  TownMesh mesh;
  for (const Mover& mover : movers) {
    std::optional<Pose2d> pose;
    const bool is_pedestrian = mover.role == Mover::Role::kPedestrian;
    if (is_pedestrian) {
      pose = place_pedestrian(town, mover, moment);
    } else if (mover.role == Mover::Role::kOncoming) {
      pose = place_oncoming(town, mover, moment);
    } else {
      pose = place_companion(town, mover, moment.driven_m);
    }
    if (!pose) continue;
    const double ground_m = ground_height_m(town.options.seed, pose->position_m);
    if (is_pedestrian) {
      add_pedestrian(mesh, *pose, ground_m, mover.seed);
    } else {
      add_vehicle(mesh, *pose, ground_m, mover.seed, Label::kMovingCar);
    }
  }
  return mesh;
}

}  // namespace sightline::town
