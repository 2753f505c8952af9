#include "passes/map/sharpness/measure_sharpness.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "formats/drive/scan_stores.h"
#include "formats/drive/trajectory.h"
#include "formats/grid/cell_key.h"
#include "formats/surroundings/surface_points.h"
#include "passes/matching/scan_preparation.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

// Points of a scan are thinned to one in a voxel, or near rings would outvote all else.
constexpr double kLeaf_m = 0.15;

// What is kept of thinned scans, which several tiles ask for: 128 m of way, with most sensors.
constexpr std::size_t kMostKept_bytes = std::size_t{32} << 20;
constexpr std::size_t kMostKept_scans = 64;

// Of each scan the points that take part, one in a voxel.
class ThinnedScanStore : public ScanStore {
 public:
  ThinnedScanStore(const Drive& drive, double reach_m) : drive_(drive), reach_m_(reach_m) {}

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_ASSIGN(const Scan scan, drive_.store->read(index));
    const double min_range_m = drive_.sensor_of(drive_.scans[index]).min_range_m;
    std::vector<Eigen::Vector3d> near_m;
    for (const Eigen::Vector3d& point_m : crop(scan.points_m, reach_m_)) {
      if (point_m.norm() >= min_range_m) near_m.push_back(point_m);
    }
    Scan thinned;
    thinned.stamp_ns = scan.stamp_ns;
    thinned.points_m = voxel_subsample(near_m, kLeaf_m);
    return thinned;
  }

 private:
  const Drive& drive_;
  double reach_m_;
};

// A scan that takes part, and where its vehicle was.
struct LaidScan {
  std::size_t index = 0;  // of the drive
  Pose T_laid_vehicle = Pose::Identity();
};

// Of those laid one scan in so much of the way. Positions in the drive.
std::vector<std::size_t> take_scans(double scan_step_m, const Trajectory& trajectory) {
  std::vector<std::size_t> taken;
  for (std::size_t k = 0; k < trajectory.poses.size(); ++k) {
    if (!trajectory.poses[k].is_laid) continue;
    const Eigen::Vector3d at_m = trajectory.poses[k].T_map_vehicle.translation();
    if (!taken.empty()) {
      const Pose& last = trajectory.poses[taken.back()].T_map_vehicle;
      if ((at_m - last.translation()).norm() < scan_step_m) continue;
    }
    taken.push_back(k);
  }
  return taken;
}

// The points of a drive as one set of poses lays them, tile by tile: a tile needs the scans that
// reach it and its rim, and nothing else is in memory.
class Laying {
 public:
  // `thinned`: the drive's scans as ThinnedScanStore gives them.
  Laying(const MeasureSharpnessOptions& options, const Drive& drive,
         std::shared_ptr<const ScanStore> thinned, std::vector<LaidScan> scans)
      : options_(options),
        drive_(drive),
        thinned_(std::move(thinned)),
        scans_(std::move(scans)),
        tile_m_(options.cell_m * std::ceil(kLeastTile_m / options.cell_m)) {
    std::set<TileKey> tiles;
    for (const LaidScan& scan : scans_) {
      visit_tiles(scan, [&](const TileKey& tile) { tiles.insert(tile); });
    }
    tiles_.assign(tiles.begin(), tiles.end());
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      visit_tiles(scans_[i], [&](const TileKey& tile) { scans_of_tile_[tile].push_back(i); });
    }
  }

  [[nodiscard]] std::size_t tile_count() const { return tiles_.size(); }

  // Error: what reading a scan says.
  [[nodiscard]] Result<SharpnessSums> sums_of_tile(std::size_t number) const {
    const TileKey& tile = tiles_[number];
    std::vector<Eigen::Vector3d> around_m;
    for (const std::size_t i : scans_of_tile_.at(tile)) {
      SIGHTLINE_TRY(append_near(scans_[i], tile, around_m));
    }
    const IsOwn is_own = [&](const Eigen::Vector3d& point_m) {
      return tile_key(point_m, tile_m_) == tile;
    };
    return sharpness_sums(around_m, is_own, options_, /*threads=*/1);
  }

  // Of the scans that reach a tile, as they are laid.
  [[nodiscard]] std::optional<Digest> content(std::size_t number) const {
    const TileKey& tile = tiles_[number];
    std::vector<PlacedScan> scans;
    for (const std::size_t i : scans_of_tile_.at(tile)) {
      const std::size_t index = scans_[i].index;
      const SensorProfile& sensor = drive_.sensor_of(drive_.scans[index]);
      scans.push_back({static_cast<std::uint32_t>(index),
                       scans_[i].T_laid_vehicle * sensor.T_vehicle_lidar, sensor.min_range_m,
                       options_.reach_m});
    }
    return content_of_scans(*drive_.store, scans, written(tile));
  }

 private:
  static constexpr double kLeastTile_m = 64.0;

  // Of the vehicle's place, as far as returns and the neighbours of points reach.
  [[nodiscard]] double reach_m() const {
    const double mounting_m = drive_.sensor.T_vehicle_lidar.translation().norm();
    return options_.reach_m + mounting_m + options_.radius_m;
  }

  template <class Visit>
  void visit_tiles(const LaidScan& scan, const Visit& visit) const {
    const Eigen::Vector3d at_m = scan.T_laid_vehicle.translation();
    const TileKey low = tile_key(at_m.array() - reach_m(), tile_m_);
    const TileKey high = tile_key(at_m.array() + reach_m(), tile_m_);
    for (std::int32_t x = low.x; x <= high.x; ++x) {
      for (std::int32_t y = low.y; y <= high.y; ++y) visit(TileKey{x, y});
    }
  }

  // The points of a scan in a tile and its rim.
  [[nodiscard]] Result<void> append_near(const LaidScan& laid, const TileKey& tile,
                                         std::vector<Eigen::Vector3d>& points_m) const {
    SIGHTLINE_ASSIGN(const Scan scan, thinned_->read(laid.index));
    const SensorProfile& sensor = drive_.sensor_of(drive_.scans[laid.index]);
    const Pose T_laid_lidar = laid.T_laid_vehicle * sensor.T_vehicle_lidar;
    const double low_x = tile.x * tile_m_ - options_.radius_m;
    const double low_y = tile.y * tile_m_ - options_.radius_m;
    const double edge_m = tile_m_ + 2.0 * options_.radius_m;
    for (const Eigen::Vector3d& point_m : scan.points_m) {
      const Eigen::Vector3d at_m = T_laid_lidar * point_m;
      const bool is_near = at_m.x() >= low_x && at_m.x() <= low_x + edge_m && at_m.y() >= low_y &&
                           at_m.y() <= low_y + edge_m;
      if (is_near) points_m.push_back(at_m);
    }
    return {};
  }

  const MeasureSharpnessOptions& options_;
  const Drive& drive_;
  std::shared_ptr<const ScanStore> thinned_;
  std::vector<LaidScan> scans_;
  double tile_m_;
  std::vector<TileKey> tiles_;                                 // ascending
  std::map<TileKey, std::vector<std::size_t>> scans_of_tile_;  // positions in scans_, ascending
};

// Figures of layings, each tile of each a part of the work. Error: what reading a scan says.
Result<std::vector<SharpnessFigures>> measure_layings(const PassContext& ctx,
                                                      const std::vector<Laying>& layings) {
  std::vector<std::vector<SharpnessSums>> sums;
  std::vector<std::pair<std::size_t, std::size_t>> tile_of_part;  // laying, tile
  for (std::size_t i = 0; i < layings.size(); ++i) {
    sums.emplace_back(layings[i].tile_count());
    for (std::size_t tile = 0; tile < sums[i].size(); ++tile) tile_of_part.emplace_back(i, tile);
  }
  RecordWork<SharpnessSums> work;
  work.count = tile_of_part.size();
  work.content = [&](std::size_t part) {
    const auto [laying, tile] = tile_of_part[part];
    return layings[laying].content(tile);
  };
  work.make = [&](std::size_t part, int /*threads*/) {
    const auto [laying, tile] = tile_of_part[part];
    return layings[laying].sums_of_tile(tile);
  };
  work.take = [&](std::size_t part, const SharpnessSums& found) {
    const auto [laying, tile] = tile_of_part[part];
    sums[laying][tile] = found;
    return true;
  };
  SIGHTLINE_TRY(work_in_parts(ctx, work));
  std::vector<SharpnessFigures> figures;
  for (const std::vector<SharpnessSums>& of_tiles : sums) figures.push_back(figures_of(of_tiles));
  return figures;
}

}  // namespace

std::vector<OptionField> option_fields(MeasureSharpnessOptions& options) {
  return {
      number("radius_m", options.radius_m, "radius around a point, for the entropy, m", 0.1, 5.0),
      number("cell_m", options.cell_m, "edge length of the cells whose thickness is measured, m",
             0.25, 10.0),
      number("scan_step_m", options.scan_step_m,
             "distance along the route between the compared scans, m", 0.1, 100.0),
      number("reach_m", options.reach_m, "largest distance of the used returns from the sensor, m",
             5.0, 300.0)};
}

Result<Sharpness> measure_sharpness(PassContext& ctx, const MeasureSharpnessOptions& options,
                                    const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  std::vector<LaidScan> by_map;
  std::vector<LaidScan> by_given;
  for (const std::size_t k : take_scans(options.scan_step_m, trajectory)) {
    by_map.push_back({k, trajectory.poses[k].T_map_vehicle});
    if (const std::optional<Pose>& T_world_vehicle = drive.scans[k].T_world_vehicle) {
      by_given.push_back({k, rebase(*T_world_vehicle, MapFrame{}, drive.frame)});
    }
  }
  const bool is_given = trajectory.source == PoseSource::kGiven;
  const bool has_given = !is_given && !by_given.empty() && by_given.size() == by_map.size();
  const std::shared_ptr<const ScanStore> thinned =
      ScanMemory::before(std::make_shared<const ThinnedScanStore>(drive, options.reach_m),
                         std::make_shared<ScanMemory>(kMostKept_bytes, kMostKept_scans));
  std::vector<Laying> layings;
  layings.emplace_back(options, drive, thinned, std::move(by_map));
  if (has_given) layings.emplace_back(options, drive, thinned, std::move(by_given));
  SIGHTLINE_ASSIGN(const std::vector<SharpnessFigures> figures, measure_layings(ctx, layings));
  Sharpness sharpness;
  sharpness.of_map = figures.front();
  if (is_given || has_given) sharpness.of_given = figures.back();
  return sharpness;
}

}  // namespace sightline
