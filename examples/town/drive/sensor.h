#pragma once

#include <functional>
#include <string>
#include <vector>

#include "examples/town/drive/caster.h"
#include "formats/base/random.h"
#include "formats/base/result.h"
#include "formats/drive/sensor_profile.h"
#include "formats/geometry.h"

// A spinning LiDAR: rings, azimuth steps, noise along the ray, returns that fail to come. One that
// does not see all round sweeps from its right to its left.

namespace sightline::town {

// The profile generic-16, -32, -64 or -128, 0.5 to 100 m, 1.8 m above the vehicle's origin.
// Error: bad-argument.
Result<SensorProfile> town_sensor(int beams);
// A built-in profile or one of a file (sensor_file.h) above the vehicle's origin, as high as it
// says. Errors: unknown-name, those of read_sensor_file.
Result<SensorProfile> town_sensor(const std::string& name);

struct LabelledPoint {
  Eigen::Vector3f position_m = Eigen::Vector3f::Zero();  // sensor frame
  float intensity = 0.0F;                                // 0 to 255
  Label label = Label::kGround;                          // what it hit
  double turn_share = 0.0;                               // of the revolution, when it was measured
};

// What a sensor looks at: that which stands, and that which moves.
struct Scene {
  const TownCaster& standing;
  const TownCaster& moving;
  const TownCaster* with_sensor = nullptr;  // in the sensor's frame: it travels with it
};

// Where a sensor is when so large a share of a revolution is over: T_town_lidar.
using SensorMotion = std::function<Pose(double share)>;

// One revolution, by azimuth counter-clockwise from +x or from the right end of its view, then by
// ring from below. Rays without a return leave no point.
std::vector<LabelledPoint> spin(const Scene& scene, const SensorProfile& sensor,
                                double range_sigma_m, const SensorMotion& motion, Random& random);

}  // namespace sightline::town
