#pragma once

#include <cstdint>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// A small square of something solid; rays hit it from both sides.
struct SurfacePatch {
  CellKey key;  // of the surface grid; unique
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit length, z >= 0
  double half_side_m = 0.0;
};

// Unit vector along one pair of sides; the other pair is at right angles to it and to the normal.
// Level where the patch is steep; on ground the sides run along the map's axes.
Eigen::Vector3d side_of(const SurfacePatch& patch);

// What rays can hit: one patch for each occupied cell of a grid finer than the NDT map's.
struct Surface {
  MapFrame frame;
  double cell_m = 0.0;
  double tile_m = 0.0;
  std::vector<SurfacePatch> patches;  // ascending by (tile, key)
};

template <>
struct ArtifactTraits<Surface> {
  static constexpr std::string_view kName = "surface";
  static constexpr std::uint32_t kVersion = 2;
};

Result<void> validate(const Surface& surface);
Table dump(const Surface& surface);
void encode(const Surface& surface, ByteWriter& writer);
void decode(ByteReader& reader, Surface& surface);

}  // namespace sightline
