#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass_context.h"

// Whether the scans of a drive show a map at the drive's poses, and by what constant the poses
// differ from the map's; part of align-drive.

namespace sightline {

// A scan of a drive, matched with a map from its pose ("Drives beside a map" in
// schemas/definitions.md).
struct ScanOnMap {
  std::size_t scan = 0;
  // Share of its upright returns that meet surfaces of the map; none where too few can be compared.
  std::optional<double> met_share;
  bool fits = false;                                      // it shows the map where it was matched
  Pose T_map_lidar = Pose::Identity();                    // its match
  Eigen::Matrix3d constrained = Eigen::Matrix3d::Zero();  // projector on directions it constrains
};

// Evenly, at most 16 scans of those whose sensor is within 10 m of a site, each matched from its
// pose and, where that may be wrong, from starts up to 3 m around. `T_map_lidar`: of all scans
// of the drive. Shared by ctx.threads. Errors: those of reading a scan, cannot-read.
Result<std::vector<ScanOnMap>> scans_on_map(const PassContext& ctx, const Drive& drive,
                                            const std::vector<Pose>& T_map_lidar,
                                            const TiledNds& nds, const Sites& sites);

// Error: no-overlap where fewer than a fifth of the scans that can be compared, of five or more,
// fit.
Result<void> check_shows_map(const Drive& drive, const std::vector<ScanOnMap>& scans);

// The poses of a drive minus those of the map.
struct PoseOffset {
  // In axes of the map or, where `is_of_vehicle`, of the vehicle: forward, left and up. 0 along a
  // direction that the scans do not constrain.
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  bool is_of_vehicle = false;
};

// None where it is not constant over the scans that fit, is not significant, or is at most 5 cm.
std::optional<PoseOffset> constant_offset(const Drive& drive, const std::vector<ScanOnMap>& scans,
                                          const std::vector<Pose>& T_map_lidar);

}  // namespace sightline
