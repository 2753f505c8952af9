#include "examples/town/world/hard/road.h"

#include <algorithm>
#include <cmath>

namespace sightline::town {
namespace {

constexpr double kBuried_m = -0.15;  // things begin below the uneven ground

// Of the uneven ground, times that of a town.
double roughness(PlaceKind kind) {
  switch (kind) {
    case PlaceKind::kTown:
      return 1.0;
    case PlaceKind::kForest:
      return 0.6;
    case PlaceKind::kHills:
      return 0.3;
    case PlaceKind::kField:
    case PlaceKind::kPlaza:
      return 0.1;
    case PlaceKind::kTunnel:
    case PlaceKind::kMotorway:
    case PlaceKind::kNoiseBarrier:
    case PlaceKind::kBridge:
    case PlaceKind::kCarPark:
      break;
  }
  return 0.0;
}

// Changes from place to place within 10 m.
double roughness_at(const std::vector<Place>& places, double s_m) {
  constexpr double kHalf_m = 5.0;
  const double before = roughness(place_at(places, s_m - kHalf_m).kind);
  const double after = roughness(place_at(places, s_m + kHalf_m).kind);
  if (before == after) return before;
  const Place& here = place_at(places, s_m);
  const double border_m = s_m - here.from_m < kHalf_m ? here.from_m : here.to_m;
  const double share = std::clamp(0.5 + 0.5 * (s_m - border_m) / kHalf_m, 0.0, 1.0);
  return std::lerp(before, after, share * share * (3.0 - 2.0 * share));
}

// Cubic between values a and b with derivatives da and db at both ends of a step.
struct Cubic {
  double a, b, da, db;
  [[nodiscard]] double at(double t, double step) const {
    const double u = 1.0 - t;
    return u * u * ((1.0 + 2.0 * t) * a + t * step * da) +
           t * t * ((1.0 + 2.0 * u) * b - u * step * db);
  }
  [[nodiscard]] double slope_at(double t, double step) const {
    const double u = 1.0 - t;
    return 6.0 * t * u * (b - a) / step + u * (u - 2.0 * t) * da + t * (t - 2.0 * u) * db;
  }
};

RoadPoint beyond(const LinePoint& end, double by_m) {
  const Eigen::Vector2d p = end.position_m + by_m * direction(end.heading_rad);
  return {Eigen::Vector3d(p.x(), p.y(), end.height_m), end.heading_rad, 0.0};
}

}  // namespace

RoadPoint Road::at(double s_m) const {
  if (s_m < 0.0) return beyond(line.points.front(), s_m);
  if (s_m >= line.length_m()) return beyond(line.points.back(), s_m - line.length_m());
  const auto i = static_cast<std::size_t>(s_m / kLineStepM);
  const LinePoint& a = line.points[i];
  const LinePoint& b = line.points[i + 1];
  const double t = s_m / kLineStepM - static_cast<double>(i);
  const Eigen::Vector2d ahead_a = direction(a.heading_rad);
  const Eigen::Vector2d ahead_b = direction(b.heading_rad);
  RoadPoint point;
  for (int axis = 0; axis < 2; ++axis) {
    const Cubic cubic{a.position_m[axis], b.position_m[axis], ahead_a[axis], ahead_b[axis]};
    point.position_m[axis] = cubic.at(t, kLineStepM);
  }
  const Cubic height{a.height_m, b.height_m, a.slope, b.slope};
  point.position_m.z() = height.at(t, kLineStepM);
  point.slope = height.slope_at(t, kLineStepM);
  point.heading_rad = std::lerp(a.heading_rad, b.heading_rad, t);
  return point;
}

Eigen::Vector3d Road::on(double s_m, double lateral_m, double up_m) const {
  const RoadPoint point = at(s_m);
  const Eigen::Vector2d p =
      point.position_m.head<2>() + lateral_m * left_of(direction(point.heading_rad));
  return Eigen::Vector3d(p.x(), p.y(), point.position_m.z() + up_m);
}

double Road::ground_m(double s_m, double lateral_m) const {
  const double share = roughness_at(places, s_m);
  if (share == 0.0) return 0.0;
  return share * ground_height_m(seed, Eigen::Vector2d(s_m, lateral_m));
}

void extrude(TownMesh& mesh, const Road& road, const Stretch& stretch, const Profile& profile,
             Label label) {
  constexpr double kStep_m = 2.0;
  const double length_m = stretch.to_m - stretch.from_m;
  const int steps = std::max(1, static_cast<int>(std::ceil(length_m / kStep_m - 1e-9)));
  const auto s_at = [&](int step) { return stretch.from_m + length_m * step / steps; };
  for (int step = 0; step < steps; ++step) {
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
      const auto& [lateral_a, up_a] = profile[i];
      const auto& [lateral_b, up_b] = profile[i + 1];
      add_quad(mesh,
               {road.on(s_at(step), lateral_a, up_a), road.on(s_at(step + 1), lateral_a, up_a),
                road.on(s_at(step + 1), lateral_b, up_b), road.on(s_at(step), lateral_b, up_b)},
               label);
    }
  }
}

void extrude_bar(TownMesh& mesh, const Road& road, const Stretch& stretch, Profile profile,
                 Label label) {
  profile.push_back(profile.front());
  extrude(mesh, road, stretch, profile, label);
}

void add_road_box(TownMesh& mesh, const Road& road, const Placement& at, const BoxSize& size,
                  Label label) {
  const Eigen::Vector3d base_m = road.on(at.s_m, at.lateral_m, 0.0);
  add_box(mesh,
          {base_m.head<2>(), road.at(at.s_m).heading_rad, size.length_m, size.width_m,
           base_m.z() + size.bottom_m, base_m.z() + size.top_m},
          label);
}

void add_road_pole(TownMesh& mesh, const Road& road, const Placement& at, double radius_m,
                   double top_m, Label label) {
  const Eigen::Vector3d base_m = road.on(at.s_m, at.lateral_m, 0.0);
  add_prism(mesh, {base_m.head<2>(), radius_m, base_m.z() + kBuried_m, base_m.z() + top_m, 8},
            label);
}

std::vector<double> evenly(const Stretch& stretch, double pitch_m) {
  std::vector<double> all;
  for (int i = 0;; ++i) {
    const double s_m = stretch.from_m + (i + 0.5) * pitch_m;
    if (s_m >= stretch.to_m) return all;
    all.push_back(s_m);
  }
}

}  // namespace sightline::town
