#pragma once

#include <cstdint>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"

namespace sightline {

// What stood still: the returns of a mapping drive in the map frame, without what moved.
struct SurfacePoints {
  MapFrame frame;
  std::vector<Eigen::Vector3d> points_m;   // scan by scan, in the scans' own order
  std::uint64_t out_of_range_count = 0;    // outside the sensor's minimum and maximum range
  std::vector<Eigen::Vector3d> moving_m;   // what was removed, for pictures and tests
  double voxel_m = 0.0;                    // resolution of the carving; 0 when it was not done
};

template <>
struct ArtifactTraits<SurfacePoints> {
  static constexpr std::string_view kName = "surface-points";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const SurfacePoints& points);
Table dump(const SurfacePoints& points);
void encode(const SurfacePoints& points, ByteWriter& writer);
void decode(ByteReader& reader, SurfacePoints& points);

}  // namespace sightline
