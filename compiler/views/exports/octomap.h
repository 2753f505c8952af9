#pragma once

#include <cstddef>
#include <vector>

#include "formats/base/result.h"
#include "formats/surroundings/surface_points.h"

namespace sightline {

struct OctomapOptions {
  double voxel_m = 0.2;       // edge of the smallest voxels, OctoMap's resolution
  double max_range_m = 60.0;  // OctoMap's: of a longer ray only this much is known, as free
  int threads = 0;            // 0: all there are
};

// Where an octree of these voxels lies: as all exports (export_frame.h), or, where its keys do not
// reach so far, in map coordinates. The file's head says which, as a comment.
struct OctomapFrame {
  Eigen::Vector3d origin_world_m = Eigen::Vector3d::Zero();  // taken off world coordinates
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();         // added to map coordinates
  bool is_of_exports = true;
};
OctomapFrame octomap_frame(const MapFrame& frame, double voxel_m);

// The free and the occupied space of a mapping drive as OctoMap's binary file (.bt), in the frame
// of octomap_frame(), by its insertPointCloud with the default sensor model; space that no ray
// passed is left out. What moved is not occupied: the way to its returns is free. Any number of
// threads gives the same bytes. Errors: bad-value (an edge or range not above 0; a place 32768
// voxels or more from the frame's origin), empty-map (no ray), those of reading a scan.
Result<std::vector<std::byte>> octomap_bt(const SurfacePoints& surface,
                                          const OctomapOptions& options);

}  // namespace sightline
