#include "examples/town/drive/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "formats/foreign/text/sensor_file.h"
#include "formats/geometry.h"

namespace sightline::town {
namespace {

struct Material {
  double reflectivity = 0.0;  // intensity when hit squarely from near
  double absorbed = 0.0;      // share of returns that are lost whatever the angle
};

Material material(Label label) {
  switch (label) {
    case Label::kGround:
      return {20.0, 0.01};
    case Label::kKerb:
      return {35.0, 0.01};
    case Label::kFacade:
      return {60.0, 0.01};
    case Label::kWindow:
      return {12.0, 0.35};  // the beam goes through, or away at an angle
    case Label::kClutter:
      return {50.0, 0.02};
    case Label::kTrunk:
      return {30.0, 0.02};
    case Label::kCrown:
      return {40.0, 0.05};
    case Label::kPole:
      return {80.0, 0.02};
    case Label::kParkedCar:
    case Label::kMovingCar:
      return {45.0, 0.15};  // dark paint
    case Label::kPedestrian:
      return {30.0, 0.05};
    case Label::kFog:
      return {6.0, 0.4};
  }
  return {};
}

// Share of returns too weak to be seen: far away, and on surfaces hit at a grazing angle.
double lost_share(const Hit& hit, double max_range_m) {
  constexpr double kGrazingCosine = 0.15;
  constexpr double kLostWhenGrazing = 0.7;
  constexpr double kLostAtMaxRange = 0.25;
  const double far = hit.range_m / max_range_m;
  const double grazing = std::max(0.0, 1.0 - hit.cosine / kGrazingCosine);
  const double kept = (1.0 - material(hit.label).absorbed) * (1.0 - kLostAtMaxRange * far * far) *
                      (1.0 - kLostWhenGrazing * grazing);
  return 1.0 - kept;
}

float intensity_of(const Hit& hit, double noise) {
  constexpr double kHalvedAtM = 60.0;
  constexpr double kNoise = 2.0;
  const double falloff = 1.0 / (1.0 + (hit.range_m / kHalvedAtM) * (hit.range_m / kHalvedAtM));
  const double value =
      material(hit.label).reflectivity * (0.4 + 0.6 * hit.cosine) * falloff + kNoise * noise;
  return static_cast<float>(std::clamp(std::round(value), 0.0, 255.0));
}

// `ray` is in the sensor's frame.
Hit nearest(const Scene& scene, const Pose& T_town_lidar, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d origin_m = T_town_lidar.translation();
  const Eigen::Vector3d direction = T_town_lidar.linear() * ray;
  const Hit standing = scene.standing.cast(origin_m, direction);
  const Hit moving = scene.moving.cast(origin_m, direction);
  Hit hit = moving.range_m < standing.range_m ? moving : standing;
  if (scene.with_sensor == nullptr) return hit;
  const Hit carried = scene.with_sensor->cast(Eigen::Vector3d::Zero(), ray);
  return carried.range_m < hit.range_m ? carried : hit;
}

}  // namespace

Result<SensorProfile> town_sensor(int beams) {
  constexpr std::array<int, 4> kKnown = {16, 32, 64, 128};
  if (std::find(kKnown.begin(), kKnown.end(), beams) == kKnown.end()) {
    return Error{ErrorCode::kBadArgument,
                 "a sensor of " + std::to_string(beams) + " beams; expected 16, 32, 64 or 128",
                 {},
                 {}};
  }
  SIGHTLINE_ASSIGN(SensorProfile sensor, sensor_profile("generic-" + std::to_string(beams)));
  sensor.min_range_m = 0.5;
  sensor.max_range_m = 100.0;
  sensor.height_m = 1.8;
  sensor.T_vehicle_lidar = Pose::Identity();
  sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.0, 0.0, sensor.height_m);
  return sensor;
}

Result<SensorProfile> town_sensor(const std::string& name) {
  SIGHTLINE_ASSIGN(SensorProfile sensor,
                   is_sensor_file(name) ? read_sensor_file(name) : sensor_profile(name));
  sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.0, 0.0, sensor.height_m);
  return sensor;
}

std::vector<LabelledPoint> spin(const Scene& scene, const SensorProfile& sensor,
                                double range_sigma_m, const SensorMotion& motion, Random& random) {
  const int azimuths = sensor.azimuth_count();
  std::vector<LabelledPoint> points;
  points.reserve(static_cast<std::size_t>(azimuths) * sensor.beam_elevations_deg.size());
  for (int step = 0; step < azimuths; ++step) {
    const double azimuth = to_radians(sensor.azimuth_deg(step));
    const double share = static_cast<double>(step) / static_cast<double>(azimuths);
    const Pose T_town_lidar = motion(share);
    for (const double elevation_deg : sensor.beam_elevations_deg) {
      const double elevation = to_radians(elevation_deg);
      const Eigen::Vector3d ray = direction_of(azimuth, elevation);
      const Hit hit = nearest(scene, T_town_lidar, ray);
      if (hit.range_m > sensor.max_range_m) continue;
      if (random.uniform() < lost_share(hit, sensor.max_range_m)) continue;
      const double range_m = hit.range_m + range_sigma_m * random.normal();
      const float intensity = intensity_of(hit, random.normal());
      if (range_m < sensor.min_range_m || range_m > sensor.max_range_m) continue;
      points.push_back({(range_m * ray).cast<float>(), intensity, hit.label, share});
    }
  }
  return points;
}

}  // namespace sightline::town
