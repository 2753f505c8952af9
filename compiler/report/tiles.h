#pragma once

#include <cmath>

#include "compiler/report/json_text.h"
#include "formats/ndt_map.h"

namespace sightline {

// The tile over which a point lies.
inline TileKey tile_at(const Eigen::Vector3d& point_m, double tile_m) {
  return {floor_to_int(point_m.x() / tile_m), floor_to_int(point_m.y() / tile_m)};
}

inline std::vector<JsonMember> tile_members(TileKey key) {
  return {{"x", std::to_string(key.x)}, {"y", std::to_string(key.y)}};
}

}  // namespace sightline
