#include "examples/town/drive/road_traffic.h"

#include <cmath>
#include <optional>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "formats/geometry.h"

namespace sightline::town {
namespace {

constexpr double kSeen_m = 110.0;
constexpr double kLorryLateral_m = 3.6;
constexpr double kLorryWindow_m = 120.0;  // of our way, in which one overtakes
constexpr double kLorryReach_m = 30.0;    // from there ahead to there behind

bool has_oncoming(PlaceKind kind) {
  return kind == PlaceKind::kTown || kind == PlaceKind::kField || kind == PlaceKind::kForest ||
         kind == PlaceKind::kHills;
}

bool has_lorries(PlaceKind kind, double lateral_m) {
  if (kind == PlaceKind::kMotorway) return true;
  const bool has_left_lane =
      kind == PlaceKind::kTunnel || kind == PlaceKind::kNoiseBarrier || kind == PlaceKind::kBridge;
  return has_left_lane && lateral_m > 0.0;
}

bool has_leaders(PlaceKind kind) {
  return kind != PlaceKind::kCarPark && kind != PlaceKind::kPlaza;
}

void draw_leaders(std::vector<Mover>& movers, double length_m, double times, Random& random) {
  double from_m = random.uniform(0.0, 60.0);
  while (from_m < length_m) {
    Mover mover;
    mover.role = Mover::Role::kLeader;
    mover.start_m = random.uniform(12.0, 28.0);
    mover.active_from_m = from_m;
    mover.active_to_m = from_m + random.uniform(60.0, 120.0);
    mover.seed = random.next();
    movers.push_back(mover);
    from_m = mover.active_to_m + random.uniform(60.0, 160.0) / times;
  }
}

void draw_lorries(std::vector<Mover>& movers, double length_m, double times, Random& random) {
  double from_m = random.uniform(-60.0, 20.0);
  while (from_m < length_m) {
    Mover mover;
    mover.role = Mover::Role::kLorry;
    mover.active_from_m = from_m;
    mover.active_to_m = from_m + kLorryWindow_m;
    mover.lateral_m = kLorryLateral_m * (random.uniform() < 0.5 ? 1.0 : -1.0);
    mover.seed = random.next();
    movers.push_back(mover);
    from_m = mover.active_to_m + random.uniform(10.0, 60.0) / times;
  }
}

void draw_oncoming(std::vector<Mover>& movers, double reach_m, double times, Random& random) {
  for (double s_m = random.uniform(20.0, 60.0); s_m < reach_m;
       s_m += random.uniform(40.0, 140.0) / times) {
    Mover mover;
    mover.start_m = s_m;
    mover.speed_m_s = -10.0;
    mover.lateral_m = kNextLane_m;
    mover.seed = random.next();
    movers.push_back(mover);
  }
}

// Where on the road it is, if it is anywhere.
std::optional<Placement> placement_of(const Town& town, const Mover& mover, const Moment& moment) {
  Placement at{0.0, mover.lateral_m};
  if (mover.role == Mover::Role::kOncoming) {
    at.s_m = mover.start_m + mover.speed_m_s * moment.time_s;
  } else {
    if (moment.driven_m < mover.active_from_m || moment.driven_m > mover.active_to_m) return {};
    const double middle_m = 0.5 * (mover.active_from_m + mover.active_to_m);
    // The right lane is on motorways only.
    const bool is_motorway = place_at(town.places, middle_m).kind == PlaceKind::kMotorway;
    if (!is_motorway) at.lateral_m = std::abs(at.lateral_m);
    const double share =
        2.0 * (middle_m - moment.driven_m) / (mover.active_to_m - mover.active_from_m);
    // Lorries are passed slowly where they are beside the vehicle; the gap to a car changes.
    at.s_m = moment.driven_m + (mover.role == Mover::Role::kLorry
                                    ? kLorryReach_m * share * (0.3 + 0.7 * share * share)
                                    : mover.start_m * (1.0 + 0.2 * share));
  }
  if (std::abs(at.s_m - moment.driven_m) > kSeen_m) return {};
  const PlaceKind kind = place_at(town.places, at.s_m).kind;
  const bool is_possible = mover.role == Mover::Role::kOncoming ? has_oncoming(kind)
                           : mover.role == Mover::Role::kLorry  ? has_lorries(kind, at.lateral_m)
                                                                : has_leaders(kind);
  if (!is_possible) return {};
  return at;
}

// 16.5 m long: a cab, and a box behind it.
void add_lorry(TownMesh& mesh, const Pose2d& pose, double ground_m, std::uint64_t seed) {
  const double top_m = ground_m + Random(seed).uniform(3.6, 4.0);
  const Eigen::Vector2d ahead = direction(pose.yaw_rad);
  const auto part = [&](double along_m, double length_m, double bottom_m, double up_m) {
    add_box(
        mesh,
        {pose.position_m + along_m * ahead, pose.yaw_rad, length_m, 2.5, ground_m + bottom_m, up_m},
        Label::kMovingCar);
  };
  part(-1.4, 13.6, 1.1, top_m);
  part(7.0, 2.3, 0.5, ground_m + 3.3);
  for (const double axle_m : {6.5, 2.5, -4.5, -5.8, -7.1}) {
    part(axle_m, 0.9, 0.0, ground_m + 1.0);
  }
}

}  // namespace

std::vector<Mover> draw_road_traffic(const Town& town, std::uint64_t drive, double duration_s,
                                     double times) {
  constexpr double kOncoming_m_s = 10.0;
  Random random(mix(mix(town.options.seed, 0x6c6f727279ULL), drive));
  std::vector<Mover> movers;
  const double length_m = town.options.length_m;
  draw_leaders(movers, length_m, times, random);
  draw_lorries(movers, length_m, times, random);
  draw_oncoming(movers, length_m + kSeen_m + kOncoming_m_s * duration_s, times, random);
  return movers;
}

TownMesh moving_road_mesh(const Town& town, const std::vector<Mover>& movers,
                          const Moment& moment) {
  const Road road = town.road();
  TownMesh mesh;
  for (const Mover& mover : movers) {
    const std::optional<Placement> at = placement_of(town, mover, moment);
    if (!at) continue;
    const Eigen::Vector3d base_m =
        road.on(at->s_m, at->lateral_m, road.ground_m(at->s_m, at->lateral_m));
    const bool faces_back = mover.role == Mover::Role::kOncoming;
    const Pose2d pose{base_m.head<2>(),
                      road.at(at->s_m).heading_rad + (faces_back ? std::numbers::pi : 0.0)};
    if (mover.role == Mover::Role::kLorry) {
      add_lorry(mesh, pose, base_m.z(), mover.seed);
    } else {
      add_vehicle(mesh, pose, base_m.z(), mover.seed, Label::kMovingCar);
    }
  }
  return mesh;
}

TownMesh fog_mesh(std::uint64_t seed) {
  constexpr int kPuffs = 40;
  constexpr int kDroplets = 25;  // triangles in one
  constexpr double kSize_m = 0.2;
  Random random(mix(seed, 0x666f67ULL));
  TownMesh mesh;
  for (int puff = 0; puff < kPuffs; ++puff) {
    const double azimuth_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double elevation_rad = to_radians(random.uniform(-15.0, 15.0));
    const double range_m = random.uniform(2.0, 12.0);
    const Eigen::Vector3d middle_m = range_m * direction_of(azimuth_rad, elevation_rad);
    for (int droplet = 0; droplet < kDroplets; ++droplet) {
      std::array<Eigen::Vector3d, 3> corners;
      Eigen::Vector3d off_m;
      for (double& axis : off_m) axis = 0.12 * range_m * random.normal();
      for (Eigen::Vector3d& corner : corners) {
        corner = middle_m + off_m;
        for (double& axis : corner) axis += random.uniform(-kSize_m, kSize_m);
      }
      add_triangle(mesh, corners, Label::kFog);
    }
  }
  return mesh;
}

}  // namespace sightline::town
