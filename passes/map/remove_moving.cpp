#include "passes/map/remove_moving.h"

#include <algorithm>
#include <optional>
#include <span>

#include "formats/drive/trajectory.h"
#include "passes/map/tile_carver.h"
#include "passes/pass/scan_selection.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

Result<std::vector<PlacedScan>> place_scans(const RemoveMovingOptions& options, const Drive& drive,
                                            const Trajectory& trajectory) {
  std::vector<PlacedScan> scans;
  for (std::uint32_t i = 0; i < drive.scans.size(); ++i) {
    if (!is_selected(drive.scans[i], options.scans) || !trajectory.poses[i].is_laid) continue;
    const SensorProfile& sensor = drive.sensor_of(drive.scans[i]);
    scans.push_back({i, trajectory.poses[i].T_map_vehicle * sensor.T_vehicle_lidar,
                     sensor.min_range_m, sensor.max_range_m, drive.scans[i].part});
  }
  if (!scans.empty()) return scans;
  return Error{ErrorCode::kDriveTooShort, "no scan is selected, expected at least one", "",
               "pass remove-moving"};
}

Result<ReturnCounts> count_returns(const ScanStore& store, std::span<const PlacedScan> scans) {
  ReturnCounts sum;
  for (const PlacedScan& placed : scans) {
    SIGHTLINE_ASSIGN(const Scan scan, store.read(placed.index));
    for (const Eigen::Vector3d& point_lidar_m : scan.points_m) {
      ++(is_within_range(placed, point_lidar_m) ? sum.in_range : sum.out_of_range);
    }
  }
  return sum;
}

// The parts of the work: tiles to look into, or, where nothing is to be found, scans to count, a
// block after another.
class Search {
 public:
  Search(const RemoveMovingOptions& options, const SurfacePoints& points)
      : points_(points), origins_(origins_of(points.scans)) {
    carve_.voxel_m = options.voxel_m;
    carve_.carve_range_m = options.carve_range_m;
    if (options.enabled) {
      tiles_ = tiles_to_look_at(carve_, points.scans);
    } else {
      block_count_ = (points.scans.size() + kScansInBlock - 1) / kScansInBlock;
    }
  }

  [[nodiscard]] std::size_t part_count() const { return block_count_ + tiles_.size(); }

  [[nodiscard]] Result<TileFindings> look(std::size_t part) const {
    if (tiles_.empty()) {
      TileFindings findings;
      SIGHTLINE_ASSIGN(findings.of_scans, count_returns(*points_.store, block(part)));
      return findings;
    }
    return find_moving_in_tile(carve_, *points_.store, scans_of(tiles_[part]), tiles_[part]);
  }

  [[nodiscard]] std::optional<Digest> content(std::size_t part) const {
    if (tiles_.empty()) return content_of_scans(*points_.store, block(part), ByteWriter());
    return content_of_scans(*points_.store, scans_of(tiles_[part]), written(tiles_[part]));
  }

 private:
  [[nodiscard]] std::span<const PlacedScan> block(std::size_t part) const {
    const std::size_t first = part * kScansInBlock;
    const std::size_t count = std::min(kScansInBlock, points_.scans.size() - first);
    return std::span(points_.scans).subspan(first, count);
  }

  [[nodiscard]] std::vector<PlacedScan> scans_of(const TileKey& tile) const {
    return scans_of_tile(carve_, points_.scans, origins_, tile);
  }

  static constexpr std::size_t kScansInBlock = 256;
  const SurfacePoints& points_;
  const PointGrid origins_;
  CarveOptions carve_;
  std::vector<TileKey> tiles_;
  std::size_t block_count_ = 0;
};

Result<void> search(const PassContext& ctx, const RemoveMovingOptions& options,
                    SurfacePoints& points) {
  const Search search(options, points);
  RecordWork<TileFindings> work;
  work.count = search.part_count();
  work.content = [&](std::size_t part) { return search.content(part); };
  work.make = [&](std::size_t part, int /*threads*/) { return search.look(part); };
  SIGHTLINE_ASSIGN(const std::vector<TileFindings> found, make_parts(ctx, std::move(work)));
  for (const TileFindings& part : found) {
    points.standing_count += part.of_scans.in_range;
    points.out_of_range_count += part.of_scans.out_of_range;
    points.moved_voxels.insert(points.moved_voxels.end(), part.moved_voxels.begin(),
                               part.moved_voxels.end());
    points.moving_count += part.moving_count;
  }
  std::ranges::sort(points.moved_voxels);
  return {};
}

}  // namespace

std::vector<OptionField> option_fields(RemoveMovingOptions& options) {
  return {
      flag("enabled", options.enabled, "remove objects that moved between scans"),
      number("voxel_m", options.voxel_m,
             "edge length of the voxels that are classified as static or moving, m", 0.05, 2.0),
      number("carve_range_m", options.carve_range_m,
             "largest distance from the sensor at which moving objects are searched for, m", 1.0,
             200.0),
      scans_option(options.scans),
  };
}

Result<SurfacePoints> remove_moving(PassContext& ctx, const RemoveMovingOptions& options,
                                    const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  SurfacePoints points;
  points.frame = trajectory.frame;
  points.store = drive.store;
  SIGHTLINE_ASSIGN(points.scans, place_scans(options, drive, trajectory));
  SIGHTLINE_TRY(search(ctx, options, points));
  if (points.standing_count == 0) {
    return Error{
        ErrorCode::kEmptyMap,
        concat("none of ", points.out_of_range_count, " returns is within the sensor's range of ",
               format_double(drive.sensor.min_range_m), " to ",
               format_double(drive.sensor.max_range_m), " m"),
        "", "pass remove-moving"};
  }
  points.standing_count -= points.moving_count;
  if (options.enabled) points.voxel_m = options.voxel_m;
  return points;
}

}  // namespace sightline
