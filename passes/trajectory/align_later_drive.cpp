#include "passes/trajectory/align_later_drive.h"

#include "passes/trajectory/pieces/own_pieces.h"

namespace sightline {
namespace {

// Vehicle for LiDAR: where it is laid does not matter.
Trajectory laid_aside(const Trajectory& own, const MapFrame& frame, const Sites& sites) {
  Trajectory aside = rebase(own, frame);
  std::vector<Pose> T_own_vehicle;
  for (const TrajectoryPose& pose : aside.poses) T_own_vehicle.push_back(pose.T_map_vehicle);
  std::vector<Pose> T_map_vehicle(T_own_vehicle.size(), Pose::Identity());
  lay_aside(T_own_vehicle, {0, T_own_vehicle.size()}, sites, T_map_vehicle);
  for (std::size_t k = 0; k < aside.poses.size(); ++k) {
    aside.poses[k].T_map_vehicle = T_map_vehicle[k];
  }
  return aside;
}

}  // namespace

Result<Trajectory> align_later_drive(PassContext& ctx, const AlignDriveOptions& options,
                                     const Drive& drive, const Trajectory& own, const TiledNds& nds,
                                     const Sites& sites) {
  Result<Trajectory> aligned = align_drive(ctx, options, drive, own, nds, sites);
  if (aligned || aligned.error().code != ErrorCode::kNoOverlap || own.poses.empty()) return aligned;
  ctx.warn("drive '" + drive.name + "' is found nowhere in the map (" + aligned.error().message +
           ") and laid aside");
  return laid_aside(own, nds.frame(), sites);
}

}  // namespace sightline
