#include "examples/town/drive/drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "examples/town/drive/road_traffic.h"
#include "examples/town/drive/sensor.h"
#include "examples/town/drive/way.h"
#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "formats/geometry.h"

namespace sightline::town {
namespace {

constexpr std::uint64_t kPoseKey = 0x706f7365ULL;
constexpr std::uint64_t kRayKey = 0x72617973ULL;
constexpr std::uint64_t kMissingKey = 0x6d697373ULL;

// A slowly varying error of unit deviation: three waves of the route, as long as
// positioning drifts. Shorter ones would average out in a map, which is made of many scans.
class SlowNoise {
 public:
  explicit SlowNoise(Random& random) {
    for (std::size_t i = 0; i < kWaves; ++i) {
      wavelength_m_[i] = random.uniform(0.8, 1.2) * kWavelengthsM[i];
      phase_[i] = random.uniform(0.0, 2.0 * std::numbers::pi);
    }
  }
  [[nodiscard]] double at(double s_m) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < kWaves; ++i) {
      sum += portable_sin_cos(2.0 * std::numbers::pi * s_m / wavelength_m_[i] + phase_[i]).sin;
    }
    return sum * std::sqrt(2.0 / kWaves);
  }

 private:
  static constexpr std::size_t kWaves = 3;
  static constexpr std::array<double, kWaves> kWavelengthsM = {60.0, 150.0, 310.0};
  std::array<double, kWaves> wavelength_m_{};
  std::array<double, kWaves> phase_{};
};

// Of the sensor's view, around straight behind.
void remove_covered(std::vector<LabelledPoint>& points, double covered_deg) {
  const double cosine = portable_sin_cos(to_radians(0.5 * covered_deg)).cos;
  std::erase_if(points, [&](const LabelledPoint& point) {
    const Eigen::Vector2d flat_m = point.position_m.head<2>().cast<double>();
    return -flat_m.x() > cosine * flat_m.norm();
  });
}

Result<void> check_view(const Town& town, const DriveOptions& options) {
  if (town.is_hard() && options.is_in_next_lane) {
    return Error{ErrorCode::kBadArgument, "the oncoming lane can be driven in a town only"};
  }
  if (!(options.speed_change >= 0.0 && options.speed_change < 0.5)) {
    return Error{ErrorCode::kBadArgument, "the speed changes by at least 0 and less than 0.5"};
  }
  if (!(options.covered_deg >= 0.0 && options.covered_deg < 360.0)) {
    return Error{ErrorCode::kBadArgument,
                 "the covered part of the view is at least 0 and less than 360 degrees; found " +
                     std::to_string(options.covered_deg)};
  }
  return {};
}

Result<void> check(const Town& town, const DriveOptions& options) {
  const auto refuse = [](const std::string& message) {
    return Error{ErrorCode::kBadArgument, message, {}, {}};
  };
  if (!(options.spacing_m >= 0.05 && options.spacing_m <= 50.0)) {
    return refuse("scans every " + std::to_string(options.spacing_m) + " m; expected 0.05 to 50 m");
  }
  const double longest_m = (town.options.is_round ? 2.0 : 1.0) * town.options.length_m;
  const bool is_inside = options.from_m >= 0.0 && options.from_m + options.length_m <= longest_m;
  if (!(options.length_m > 0.0 && is_inside)) {
    return refuse("a drive of " + std::to_string(options.length_m) + " m from " +
                  std::to_string(options.from_m) +
                  " m on; expected more than 0 and at most to the town's " +
                  std::to_string(longest_m) + " m");
  }
  if (!(options.range_sigma_m >= 0.0 && options.range_sigma_m <= 1.0)) {
    return refuse("range noise of " + std::to_string(options.range_sigma_m) +
                  " m; expected 0 to 1 m");
  }
  if (!(std::abs(options.lateral_m) <= 1.5 && std::abs(options.yaw_rad) <= 0.5)) {
    return refuse("a drive " + std::to_string(options.lateral_m) + " m and " +
                  std::to_string(options.yaw_rad) +
                  " rad beside the line; expected at most 1.5 m and 0.5 rad");
  }
  if (!(options.traffic >= 0.1 && options.traffic <= 10.0)) {
    return refuse(std::to_string(options.traffic) + " times the usual traffic; expected 0.1 to 10");
  }
  if (!(options.missing_share >= 0.0 && options.missing_share < 1.0)) {
    return refuse("a share of " + std::to_string(options.missing_share) +
                  " of missing returns; expected at least 0 and less than 1");
  }
  if (options.is_swept && options.look_about_rad != 0.0) {
    return refuse("a drive both on foot and swept; expected one of the two");
  }
  if (options.sensor.beam_elevations_deg.empty()) return refuse("the sensor has no beams");
  return {};
}

}  // namespace

DriveOptions usual_drive(const TownOptions& town, std::uint64_t drive,
                         const SensorProfile& sensor) {
  DriveOptions options;
  options.drive = drive;
  // Round a block it goes on to where it began and a little farther.
  constexpr double kOverlapM = 30.0;
  options.length_m = town.length_m + (town.is_round ? kOverlapM : 0.0);
  options.sensor = sensor;
  if (town.world.is_hard) {
    // What is dark or wet is not seen farther, and the ends of a place would constrain its middle.
    constexpr double kMostRange_m = 60.0;
    options.sensor.max_range_m = std::min(sensor.max_range_m, kMostRange_m);
    options.speed_change = 0.05;
  }
  if (drive == 1) {
    options.lateral_m = 0.1;
    options.yaw_rad = to_radians(0.3);
    options.range_sigma_m = 0.0225;
  } else if (drive >= 2) {
    options.lateral_m = -0.3;
    options.yaw_rad = to_radians(-0.5);
    options.range_sigma_m = 0.025;
  }
  return options;
}

DriveOptions carried_by_hand(DriveOptions options) {
  options.spacing_m = 0.7;
  options.scan_period_ns = 500'000'000;
  options.look_about_rad = to_radians(60.0);
  return options;
}

Result<DriveSimulator> DriveSimulator::make(const Town& town, const DriveOptions& options) {
  SIGHTLINE_TRY(check(town, options));
  SIGHTLINE_TRY(check_view(town, options));
  DriveSimulator drive;
  drive.town_ = &town;
  drive.options_ = options;
  drive.poses_ = follow_line(town, options);
  const double duration_s = 1e-9 * static_cast<double>(drive.stamp_ns(drive.poses_.size()));
  drive.movers_ = town.is_hard()
                      ? draw_road_traffic(town, options.drive, duration_s, options.traffic)
                      : draw_traffic(town, options.drive, duration_s, options.traffic);
  if (options.is_in_next_lane) {
    std::erase_if(drive.movers_,
                  [](const Mover& mover) { return mover.role == Mover::Role::kOncoming; });
  }
  drive.standing_ = std::make_unique<TownCaster>(standing_mesh(town, options.drive));
  if (options.has_fog) {
    drive.fog_ = std::make_unique<TownCaster>(fog_mesh(mix(town.options.seed, options.drive)));
  }
  return drive;
}

std::int64_t DriveSimulator::stamp_ns(std::size_t index) const {
  return static_cast<std::int64_t>(index) * options_.scan_period_ns;
}

double DriveSimulator::driven_m(std::size_t index) const {
  return driven_line_m(options_, static_cast<double>(index));
}

std::vector<Pose> DriveSimulator::disturbed_poses() const {
  // Slow and white deviations on each axis; together 2.1 cm and 0.04 degrees.
  constexpr std::array<double, 3> kSlowM = {0.013, 0.013, 0.008};
  constexpr double kWhiteM = 0.003;
  constexpr std::array<double, 3> kSlowDeg = {0.017, 0.017, 0.03};
  constexpr double kWhiteDeg = 0.01;
  Random random(mix(mix(town_->options.seed, kPoseKey), options_.drive));
  std::vector<SlowNoise> slow;
  for (int i = 0; i < 6; ++i) slow.emplace_back(random);
  std::vector<Pose> poses = poses_;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double s_m = driven_m(i);
    Eigen::Vector3d shift_m;
    Eigen::Vector3d turn_rad;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(axis);
      shift_m[row] = kSlowM[axis] * slow[axis].at(s_m) + kWhiteM * random.normal();
      turn_rad[row] =
          to_radians(kSlowDeg[axis] * slow[axis + 3].at(s_m) + kWhiteDeg * random.normal());
    }
    poses[i].translation() += shift_m;
    const double angle_rad = turn_rad.norm();
    const Eigen::Vector3d turn_axis = turn_rad.normalized();
    poses[i].linear() *= rotation_matrix({turn_axis, angle_rad});
  }
  return poses;
}

Pose DriveSimulator::T_town_vehicle_at(double time_s) const {
  SIGHTLINE_CHECK(options_.is_swept);
  const double scans = 1e9 * time_s / static_cast<double>(options_.scan_period_ns);
  return pose_on_way(*town_, options_, scans, 0.0);
}

TownMesh DriveSimulator::moving_mesh_at(std::size_t index) const {
  const Moment moment{1e-9 * static_cast<double>(stamp_ns(index)), driven_m(index)};
  return town_->is_hard() ? moving_road_mesh(*town_, movers_, moment)
                          : moving_mesh(*town_, movers_, moment);
}

TownScan DriveSimulator::scan(std::size_t index) const {
  const TownCaster moving(moving_mesh_at(index));
  TownScan scan;
  scan.stamp_ns = stamp_ns(index);
  scan.T_town_vehicle = poses_[index];
  Random random(mix(mix(mix(town_->options.seed, kRayKey), options_.drive), index));
  const TownChange& change = town_->options.change;
  const bool is_changed = change.is_at(driven_m(index));
  const double sigma_m = options_.range_sigma_m * (is_changed ? change.noise_factor : 1.0);
  const double period_s = 1e-9 * static_cast<double>(options_.scan_period_ns);
  const auto T_town_lidar = [&](double share) -> Pose {
    if (!options_.is_swept) return poses_[index] * options_.sensor.T_vehicle_lidar;
    const double time_s = period_s * (static_cast<double>(index) + share);
    return T_town_vehicle_at(time_s) * options_.sensor.T_vehicle_lidar;
  };
  scan.points =
      spin({*standing_, moving, fog_.get()}, options_.sensor, sigma_m, T_town_lidar, random);
  // Numbers of their own: what is not missing stays as it was.
  Random missing(mix(mix(mix(town_->options.seed, kMissingKey), options_.drive), index));
  if (options_.missing_share > 0.0) {
    std::erase_if(scan.points, [&](const LabelledPoint& /*point*/) {
      return missing.uniform() < options_.missing_share;
    });
  }
  if (options_.covered_deg > 0.0) remove_covered(scan.points, options_.covered_deg);
  if (!options_.is_swept) return scan;
  for (const LabelledPoint& point : scan.points) {
    const double offset_ns = static_cast<double>(options_.scan_period_ns) * point.turn_share;
    scan.time_offset_ns.push_back(static_cast<std::int32_t>(offset_ns));
  }
  return scan;
}

std::vector<TownScan> simulate(const DriveSimulator& drive, int threads) {
  return parallel_map<TownScan>(drive.scan_count(), threads,
                                [&](std::size_t i) { return drive.scan(i); });
}

Drive recorded(const DriveSimulator& drive, const std::string& name, std::span<const Pose> poses,
               int threads) {
  SIGHTLINE_CHECK(poses.size() == drive.scan_count());
  Drive made;
  made.name = name;
  made.sensor = drive.sensor();
  std::vector<Scan> scans(drive.scan_count());
  parallel_for(scans.size(), threads, [&](std::size_t i) {
    const TownScan scan = drive.scan(i);
    scans[i].stamp_ns = scan.stamp_ns;
    scans[i].time_offset_ns = scan.time_offset_ns;
    for (const LabelledPoint& point : scan.points) {
      scans[i].points_m.emplace_back(point.position_m.cast<double>());
    }
  });
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ScanInfo info;
    info.recording_index = static_cast<std::uint32_t>(i);
    info.stamp_ns = scans[i].stamp_ns;
    info.point_count = scans[i].points_m.size();
    info.T_world_vehicle = poses[i];
    info.has_point_times = !scans[i].time_offset_ns.empty();
    made.scans.push_back(info);
  }
  made.store = memory_scan_store(std::move(scans));
  return made;
}

}  // namespace sightline::town
