#pragma once

#include <cstdint>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"
#include "formats/ndt_map.h"

namespace sightline {

// A small round patch of something solid; rays hit it from both sides.
struct SurfaceDisc {
  CellKey key;  // of the surface grid; unique
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit length, z >= 0
  double radius_m = 0.0;
};

// What rays can hit: one disc for each occupied cell of a grid finer than the NDT map's.
struct Surface {
  MapFrame frame;
  double cell_m = 0.0;
  double tile_m = 0.0;
  std::vector<SurfaceDisc> discs;  // ascending by (tile, key)
};

template <>
struct ArtifactTraits<Surface> {
  static constexpr std::string_view kName = "surface";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const Surface& surface);
Table dump(const Surface& surface);
void encode(const Surface& surface, ByteWriter& writer);
void decode(ByteReader& reader, Surface& surface);

}  // namespace sightline
