#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/surface_points.h"
#include "tests/support/lane/lane.h"

namespace sightline::lane {

struct Hit {
  double range_m = std::numeric_limits<double>::infinity();  // nothing hit
  Kind kind = Kind::kGround;
};

// Rays against the triangles of a lane, both faces counting; good to a tenth of a millimetre. Safe
// from several threads.
class Caster {
 public:
  explicit Caster(const Mesh& mesh);
  ~Caster();
  Caster(const Caster&) = delete;
  Caster& operator=(const Caster&) = delete;

  [[nodiscard]] Hit cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct DriveOptions {
  SensorProfile sensor;
  double length_m = 60.0;
  double spacing_m = 1.0;  // between scans
  double range_sigma_m = 0.02;
  std::uint64_t seed = 1;
  int threads = 1;
};

// What the sensor saw along the lane, at true poses, behind a store of its own: nothing moved.
SurfacePoints drive_along(const Lane& lane, const Caster& caster, const DriveOptions& options);

}  // namespace sightline::lane
