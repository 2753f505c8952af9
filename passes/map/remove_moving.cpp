#include "passes/map/remove_moving.h"

#include <algorithm>

#include "formats/base/parallel.h"
#include "formats/drive/trajectory_of_drive.h"
#include "passes/map/tile_carver.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
namespace {

Result<std::vector<PlacedScan>> place_scans(const RemoveMovingOptions& options, const Drive& drive,
                                            const Trajectory& trajectory) {
  const ScanSelection selection = options.scans;
  std::vector<PlacedScan> scans;
  for (std::uint32_t i = 0; i < drive.scans.size(); ++i) {
    if (!is_selected(drive.scans[i], selection)) continue;
    const SensorProfile& sensor = drive.sensor_of(drive.scans[i]);
    scans.push_back({i, trajectory.poses[i].T_map_vehicle * sensor.T_vehicle_lidar,
                     sensor.min_range_m, sensor.max_range_m, drive.scans[i].part});
  }
  if (!scans.empty()) return scans;
  return Error{ErrorCode::kDriveTooShort, "no scan is selected, expected at least one", "",
               "pass remove-moving"};
}

struct ReturnCounts {
  std::uint64_t in_range = 0;
  std::uint64_t out_of_range = 0;
};

Result<ReturnCounts> count_returns(const ScanStore& store, const PlacedScan& placed) {
  SIGHTLINE_ASSIGN(const Scan scan, store.read(placed.index));
  ReturnCounts counts;
  for (const Eigen::Vector3d& point_lidar_m : scan.points_m) {
    ++(is_within_range(placed, point_lidar_m) ? counts.in_range : counts.out_of_range);
  }
  return counts;
}

Result<void> count_all_returns(PassContext& ctx, const Drive& drive, SurfacePoints& points) {
  std::vector<Result<ReturnCounts>> counts(points.scans.size(), ReturnCounts{});
  parallel_for(counts.size(), ctx.threads,
               [&](std::size_t i) { counts[i] = count_returns(*drive.store, points.scans[i]); });
  for (const Result<ReturnCounts>& count : counts) {
    if (!count) return count.error();
    points.standing_count += count->in_range;
    points.out_of_range_count += count->out_of_range;
  }
  if (points.standing_count > 0) return {};
  return Error{ErrorCode::kEmptyMap,
               "none of " + std::to_string(points.out_of_range_count) +
                   " returns is within the sensor's range of " +
                   format_double(drive.sensor.min_range_m) + " to " +
                   format_double(drive.sensor.max_range_m) + " m",
               "", "pass remove-moving"};
}

Result<void> find_moving(PassContext& ctx, const RemoveMovingOptions& options,
                         SurfacePoints& points) {
  CarveOptions carve;
  carve.voxel_m = options.voxel_m;
  carve.carve_range_m = options.carve_range_m;
  const std::vector<TileKey> tiles = tiles_to_look_at(carve, points.scans);
  const PointGrid origins = origins_of(points.scans);
  std::vector<Result<TileFindings>> found(tiles.size(), TileFindings{});
  parallel_for(tiles.size(), ctx.threads, [&](std::size_t i) {
    const std::vector<PlacedScan> scans = scans_of_tile(carve, points.scans, origins, tiles[i]);
    found[i] = find_moving_in_tile(carve, *points.store, scans, tiles[i]);
    ctx.progress(i + 1, tiles.size());
  });
  for (const Result<TileFindings>& tile : found) {
    if (!tile) return tile.error();
    points.moved_voxels.insert(points.moved_voxels.end(), tile->moved_voxels.begin(),
                               tile->moved_voxels.end());
    points.moving_count += tile->moving_count;
  }
  std::ranges::sort(points.moved_voxels);
  points.standing_count -= points.moving_count;
  points.voxel_m = options.voxel_m;
  return {};
}

}  // namespace

std::vector<OptionField> option_fields(RemoveMovingOptions& options) {
  return {
      flag("enabled", options.enabled, "take out what moved between scans"),
      number("voxel_m", options.voxel_m, "edge of the voxels that stand or move as a whole, m",
             0.05, 2.0),
      number("carve_range_m", options.carve_range_m,
             "rays look for what moved up to this distance from the sensor, m", 1.0, 200.0),
      scans_option(options.scans),
  };
}

Result<SurfacePoints> remove_moving(PassContext& ctx, const RemoveMovingOptions& options,
                                    const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  SIGHTLINE_ASSIGN(std::vector<PlacedScan> scans, place_scans(options, drive, trajectory));
  SurfacePoints points;
  points.frame = trajectory.frame;
  points.scans = std::move(scans);
  points.store = drive.store;
  SIGHTLINE_TRY(count_all_returns(ctx, drive, points));
  if (options.enabled) {
    SIGHTLINE_TRY(find_moving(ctx, options, points));
  }
  return points;
}

}  // namespace sightline
