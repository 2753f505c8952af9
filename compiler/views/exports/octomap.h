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

// The free and the occupied space of a mapping drive as OctoMap's binary file (.bt) holds it, in
// the frame of octomap_frame(): octovis, octomap_server and OctoMap's own reader open it.
// Everything is OctoMap's own: each scan is inserted as its insertPointCloud does (a voxel is
// updated once a scan, and a hit outweighs what passed) with its default sensor model (hit 0.7,
// miss 0.4) and clamping (0.12 to 0.97), and what is more likely occupied than free at the end is
// occupied. Space that no ray passed is not in the file. What moved is not occupied: a return in a
// voxel that moved says that the way to it was free, and nothing of its end. The same scans give
// the same bytes for any number of threads. Errors: bad-value (an edge or range not above 0; a
// place that keys of OctoMap do not reach, 32768 voxels from the frame's origin), empty-map (no
// ray), and what reading a scan says.
Result<std::vector<std::byte>> octomap_bt(const SurfacePoints& surface,
                                          const OctomapOptions& options);

}  // namespace sightline
