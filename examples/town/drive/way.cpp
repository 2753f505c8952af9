#include "examples/town/drive/way.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "examples/town/drive/traffic.h"
#include "formats/base/portable_math.h"
#include "formats/base/random.h"

namespace sightline::town {
namespace {

constexpr std::uint64_t kLookKey = 0x6c6f6f6bULL;

constexpr double kHalfWheelbaseM = 1.35;
constexpr double kHalfTrackM = 0.8;

// A car on its four wheels: what the ground does to its height, roll and pitch. `height` is the
// ground's under a wheel: +-1 ahead, +-1 to the left.
template <class Height>
Pose stand_on_wheels(const Pose2d& place, const Height& height) {
  const Eigen::Vector2d ahead = direction(place.yaw_rad);
  const Eigen::Vector2d left = left_of(ahead);
  const double front_left = height(1, 1), front_right = height(1, -1);
  const double rear_left = height(-1, 1), rear_right = height(-1, -1);
  const double rise_ahead =
      (front_left + front_right - rear_left - rear_right) / (4.0 * kHalfWheelbaseM);
  const double rise_left =
      (front_left + rear_left - front_right - rear_right) / (4.0 * kHalfTrackM);
  const Eigen::Vector3d x = Eigen::Vector3d(ahead.x(), ahead.y(), rise_ahead).normalized();
  const Eigen::Vector3d z = x.cross(Eigen::Vector3d(left.x(), left.y(), rise_left)).normalized();
  Pose T_town_vehicle = Pose::Identity();
  T_town_vehicle.linear().col(0) = x;
  T_town_vehicle.linear().col(1) = z.cross(x);
  T_town_vehicle.linear().col(2) = z;
  T_town_vehicle.translation() =
      Eigen::Vector3d(place.position_m.x(), place.position_m.y(),
                      0.25 * (front_left + front_right + rear_left + rear_right));
  return T_town_vehicle;
}

Pose stand_on_ground(std::uint64_t seed, const Pose2d& place) {
  const Eigen::Vector2d ahead = direction(place.yaw_rad);
  const Eigen::Vector2d left = left_of(ahead);
  return stand_on_wheels(place, [&](double x, double y) {
    return ground_height_m(seed,
                           place.position_m + x * kHalfWheelbaseM * ahead + y * kHalfTrackM * left);
  });
}

// On the road of a hard world. Wheels are placed in its coordinates, as if it were straight for
// the length of a car.
Pose stand_on_road(const Road& road, const Placement& at, double turned_rad) {
  const Eigen::Vector3d base_m = road.on(at.s_m, at.lateral_m, 0.0);
  const SinCos turn = portable_sin_cos(turned_rad);
  const Pose2d place{base_m.head<2>(), road.at(at.s_m).heading_rad + turned_rad};
  return stand_on_wheels(place, [&](double x, double y) {
    const double ahead_m = x * kHalfWheelbaseM;
    const double left_m = y * kHalfTrackM;
    const double s_m = at.s_m + ahead_m * turn.cos - left_m * turn.sin;
    const double lateral_m = at.lateral_m + ahead_m * turn.sin + left_m * turn.cos;
    return road.at(s_m).position_m.z() + road.ground_m(s_m, lateral_m);
  });
}

// To the left of the line at an arc length: the next lane, reached within kChange_m of where there
// is none.
double lateral_at_m(const Town& town, const DriveOptions& options, double s_m) {
  if (!options.is_in_next_lane) return options.lateral_m;
  constexpr double kChange_m = 20.0;
  double nearest_m = kChange_m;
  for (double off_m = 0.0; off_m < kChange_m; off_m += 0.5) {
    const double ends_m = town.options.length_m;
    const bool is_narrow = !has_next_lane(town, std::max(0.0, s_m - off_m)) ||
                           !has_next_lane(town, std::min(ends_m, s_m + off_m));
    if (!is_narrow) continue;
    nearest_m = off_m;
    break;
  }
  return options.lateral_m + kNextLane_m * nearest_m / kChange_m;
}

// How far each scan looks to the left of the way, 0 or look_about_rad to either side; of seven
// scans two turn.
std::vector<double> looks_rad(std::uint64_t seed, double look_about_rad, std::size_t count) {
  std::vector<double> looks(count, 0.0);
  if (look_about_rad == 0.0) return looks;
  Random random(mix(seed, kLookKey));
  double look_rad = 0.0;
  for (std::size_t i = 2; i < count; ++i) {
    if (random.uniform(0.0, 7.0) < 2.0) {
      const double side = random.uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
      look_rad = look_rad == 0.0 ? side * look_about_rad : 0.0;
    }
    looks[i] = look_rad;
  }
  return looks;
}

// To and fro, by up to 1.6 degrees: the car turns by up to 28 degrees a second, and the other way
// a seventh of a second later.
double steered_rad(double time_s) {
  constexpr double kReach_deg = 0.8;
  const double full_rad = 2.0 * std::numbers::pi * time_s;
  return to_radians(kReach_deg *
                    (portable_sin_cos(2.3 * full_rad).sin + portable_sin_cos(3.7 * full_rad).sin));
}

constexpr double kSpeedPeriod_s = 20.0;

// As many scans as the drive's length holds.
std::size_t scans_within(const DriveOptions& options) {
  auto count = static_cast<std::size_t>(std::floor(options.length_m / options.spacing_m + 1e-9));
  if (options.speed_change == 0.0) return count + 1;
  const auto way_m = [&](std::size_t scan) {
    return std::abs(driven_line_m(options, static_cast<double>(scan)) -
                    driven_line_m(options, 0.0));
  };
  while (count > 0 && way_m(count) > options.length_m + 1e-9) --count;
  return count + 1;
}

}  // namespace

double driven_line_m(const DriveOptions& options, double scans) {
  double way_m = scans * options.spacing_m;
  if (options.speed_change != 0.0) {
    // The integral of the share sin(2 pi t / period) of the usual speed.
    const double period_scans = 1e9 * kSpeedPeriod_s / static_cast<double>(options.scan_period_ns);
    const double phase_rad = 2.0 * std::numbers::pi * scans / period_scans;
    way_m += options.speed_change * options.spacing_m * period_scans *
             (1.0 - portable_sin_cos(phase_rad).cos) / (2.0 * std::numbers::pi);
  }
  return options.is_back ? options.from_m + options.length_m - way_m : options.from_m + way_m;
}

Pose pose_on_way(const Town& town, const DriveOptions& options, double scans, double look_rad) {
  const double s_m = driven_line_m(options, scans);
  const double back_rad = options.is_back ? std::numbers::pi : 0.0;
  if (town.is_hard()) {
    return stand_on_road(town.road(), {s_m, options.lateral_m},
                         back_rad + options.yaw_rad + look_rad);
  }
  const LinePoint point = town.plan.line.at(s_m);
  const Eigen::Vector2d left = left_of(direction(point.heading_rad));
  const Pose2d place{point.position_m + lateral_at_m(town, options, s_m) * left,
                     point.heading_rad + back_rad + options.yaw_rad + look_rad};
  if (!options.is_swept) return stand_on_ground(town.options.seed, place);
  const double time_s = 1e-9 * static_cast<double>(options.scan_period_ns) * scans;
  return stand_on_ground(town.options.seed,
                         {place.position_m, place.yaw_rad + steered_rad(time_s)});
}

std::vector<Pose> follow_line(const Town& town, const DriveOptions& options) {
  std::vector<Pose> poses;
  const std::size_t count = scans_within(options);
  const std::vector<double> looks =
      looks_rad(mix(town.options.seed, options.drive), options.look_about_rad, count);
  for (std::size_t i = 0; i < count; ++i) {
    poses.push_back(pose_on_way(town, options, static_cast<double>(i), looks[i]));
  }
  return poses;
}

}  // namespace sightline::town
