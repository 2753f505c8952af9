#include "passes/map/count_drives.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "formats/drive/trajectory.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

// Fewer in a tile say nothing of it: a ray through a gap, the corner of something next door.
constexpr std::uint32_t kLeastReturns = 10;

using ScanCounts = std::map<TileKey, std::uint32_t>;

// Takes the places that follow each other at least so far apart, from the first on.
class StepByStep {
 public:
  explicit StepByStep(double step_m) : step_m_(step_m) {}
  bool takes(const Eigen::Vector3d& place_m) {
    if (last_m_ && (place_m - *last_m_).norm() < step_m_) return false;
    last_m_ = place_m;
    return true;
  }

 private:
  double step_m_;
  std::optional<Eigen::Vector3d> last_m_;
};

// Of one drive, as SurfacePointReader numbers them.
std::vector<std::size_t> scans_apart(const SurfacePoints& points, std::uint32_t part,
                                     double step_m) {
  std::vector<std::size_t> chosen;
  StepByStep way(step_m);
  for (std::size_t i = 0; i < points.scans.size(); ++i) {
    const PlacedScan& scan = points.scans[i];
    if (scan.part == part && way.takes(scan.T_map_lidar.translation())) chosen.push_back(i);
  }
  return chosen;
}

TileKey tile_of(const Eigen::Vector3d& place_m, double tile_m) {
  return {floor_to_int(place_m.x() / tile_m), floor_to_int(place_m.y() / tile_m)};
}

Result<ScanCounts> counts_of(const SurfacePoints& points, const std::vector<std::size_t>& scans,
                             double tile_m) {
  const SurfacePointReader reader(points, scans);
  ScanCounts counts;
  for (const std::size_t scan : scans) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> standing_m, reader.standing(scan));
    ScanCounts returns;
    for (const Eigen::Vector3d& point_m : standing_m) ++returns[tile_of(point_m, tile_m)];
    for (const auto& [tile, count] : returns) {
      if (count >= kLeastReturns) ++counts[tile];
    }
  }
  return counts;
}

// By drive and tile, those that are not laid.
std::vector<ScanCounts> confirming_scans(const Drive& drive, const Trajectory& trajectory,
                                         std::size_t drive_count,
                                         const CountDrivesOptions& options) {
  std::vector<ScanCounts> counts(drive_count);
  std::vector<StepByStep> ways(drive_count, StepByStep(options.step_m));
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const std::uint32_t part = drive.scans[i].part;
    const Eigen::Vector3d place_m = trajectory.poses[i].T_map_vehicle.translation();
    if (trajectory.poses[i].is_laid || !ways[part].takes(place_m)) continue;
    ++counts[part][tile_of(place_m, options.tile_m)];
  }
  return counts;
}

// In the order of the drives, without any row.
std::vector<MappedDrive> drives_of(const Drive& drive) {
  std::vector<MappedDrive> drives;
  for (const ScanInfo& scan : drive.scans) {
    while (drives.size() <= scan.part) {
      const auto part = static_cast<std::uint32_t>(drives.size());
      drives.push_back({drive.name_of_part(part), scan.stamp_ns, scan.stamp_ns});
    }
    drives[scan.part].end_ns = std::max(drives[scan.part].end_ns, scan.stamp_ns);
  }
  return drives;
}

}  // namespace

std::vector<OptionField> option_fields(CountDrivesOptions& options) {
  return {shared(number("tile_m", options.tile_m, "edge length of a map tile, m", 8.0, 1024.0)),
          number("step_m", options.step_m,
                 "least distance between the scans of a drive that are used, m", 0.0, 100.0)};
}

Result<TileDrives> count_drives(PassContext& ctx, const CountDrivesOptions& options,
                                const Drive& drive, const Trajectory& trajectory,
                                const SurfacePoints& points) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  TileDrives tiles{options.tile_m, drives_of(drive), {}};
  for (const PlacedScan& scan : points.scans) {
    if (scan.part < tiles.drives.size()) continue;
    return Error{ErrorCode::kMismatchedInputs, "the points refer to more drives than the drive has",
                 "", "pass count-drives"};
  }
  std::vector<ScanCounts> counts(tiles.drives.size());
  const auto scans_of = [&](std::size_t part) {
    return scans_apart(points, static_cast<std::uint32_t>(part), options.step_m);
  };
  using Rows = std::vector<std::pair<TileKey, std::uint32_t>>;
  RecordWork<Rows> work;
  work.count = counts.size();
  work.content = [&](std::size_t part) {
    return content_of_parts(points, scans_of(part), ByteWriter());
  };
  work.make = [&](std::size_t part, int /*threads*/) -> Result<Rows> {
    SIGHTLINE_ASSIGN(const ScanCounts made, counts_of(points, scans_of(part), options.tile_m));
    return Rows(made.begin(), made.end());
  };
  work.take = [&](std::size_t part, const Rows& rows) {
    counts[part] = ScanCounts(rows.begin(), rows.end());
    const bool are_counted =
        std::ranges::all_of(rows, [](const auto& row) { return row.second > 0; });
    return are_counted && counts[part].size() == rows.size();
  };
  SIGHTLINE_TRY(work_in_parts(ctx, work));
  const std::vector<ScanCounts> confirming =
      confirming_scans(drive, trajectory, counts.size(), options);
  std::map<std::pair<TileKey, std::uint32_t>, TileDrive> rows;
  const auto row_of = [&](TileKey tile, std::uint32_t part) -> TileDrive& {
    TileDrive& row = rows[{tile, part}];
    row.tile = tile;
    row.drive = part;
    return row;
  };
  for (std::uint32_t part = 0; part < counts.size(); ++part) {
    for (const auto& [tile, count] : counts[part]) row_of(tile, part).scan_count = count;
    for (const auto& [tile, count] : confirming[part]) {
      row_of(tile, part).confirming_scan_count = count;
    }
  }
  for (const auto& [place, row] : rows) tiles.rows.push_back(row);
  return tiles;
}

}  // namespace sightline
