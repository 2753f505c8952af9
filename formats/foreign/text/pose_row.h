#pragma once

#include <cstdint>
#include <optional>

#include "formats/geometry.h"

namespace sightline {

// One row of a pose file. Whose pose it is (the vehicle's or the sensor's) no file says; the name
// follows the default.
struct PoseRow {
  std::optional<std::int64_t> stamp_ns;
  std::optional<std::int64_t> id;
  Pose T_world_vehicle = Pose::Identity();
};

}  // namespace sightline
