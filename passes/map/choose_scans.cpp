#include "passes/map/choose_scans.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>
#include <vector>

#include "formats/base/level.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/grid/point_grid.h"
#include "passes/map/tile_carver.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

constexpr double kStep_m = 8.0;  // of a drive's way, between scans that are compared
// Earlier scans this near others are compared, and rays look so far for what has changed.
constexpr double kSeenTogether_m = 40.0;
constexpr double kSquare_m = 4.0;  // edge of the squares in which voxels are one change
// From a place so much must be confirmed within this distance: who sees nothing finds no change.
constexpr double kConfirmed_m = 30.0;
constexpr double kLeastConfirmed_m2 = 4.0;

using ScanNumbers = std::vector<std::size_t>;  // places in the drive

Eigen::Vector3d place_m(const Trajectory& trajectory, std::size_t scan) {
  return trajectory.poses[scan].T_map_vehicle.translation();
}

PointGrid grid_of(const Trajectory& trajectory, const ScanNumbers& scans) {
  constexpr double kCell_m = 16.0;
  std::vector<Eigen::Vector3d> places_m;
  for (const std::size_t scan : scans) places_m.push_back(place_m(trajectory, scan));
  return PointGrid(places_m, kCell_m);
}

// A drive passed a place where it came this near, in the same direction and on the same level; on
// the same way it came this near from the side, so that there are sites (choose_sites).
constexpr double kPassed_m = 10.0;
constexpr double kSameDirection = 0.7071067811865476;  // cosine of 45 degrees
constexpr double kSameWay_m = 2.0;

// The ways that the drives of an earlier map laid. Refers to the drive and its trajectory.
class KnownWays {
 public:
  // `earlier`: the scans that were laid, by their places in the drive.
  KnownWays(const Drive& drive, const Trajectory& trajectory, const ScanNumbers& earlier)
      : drive_(drive),
        trajectory_(trajectory),
        earlier_(earlier),
        grid_(grid_of(trajectory, earlier)) {}

  // Whether so many drives passed a scan's place in its direction, one of them on its way, from
  // behind it to ahead.
  [[nodiscard]] bool know(std::size_t scan, int drives) const {
    const TrajectoryPose& here = trajectory_.poses[scan];
    std::set<std::uint32_t> parts;
    bool comes = false;
    bool goes_on = false;
    const auto meet = [&](const NearPoint& near) {
      const std::size_t earlier = earlier_[near.index];
      const TrajectoryPose& there = trajectory_.poses[earlier];
      const Eigen::Vector3d ahead = there.T_map_vehicle.linear().col(0);
      const Eigen::Vector3d offset_m =
          here.T_map_vehicle.translation() - there.T_map_vehicle.translation();
      if (there.piece != here.piece || !is_same_level(offset_m.z(), 0.0)) return;
      if (ahead.dot(here.T_map_vehicle.linear().col(0)) < kSameDirection) return;
      parts.insert(drive_.scans[earlier].part);
      const double along_m = offset_m.dot(ahead);
      if ((offset_m - along_m * ahead).head<2>().norm() > kSameWay_m) return;
      comes = comes || along_m >= 0.0;
      goes_on = goes_on || along_m <= 0.0;
    };
    grid_.visit_within(here.T_map_vehicle.translation(), kPassed_m, meet);
    return comes && goes_on && parts.size() >= static_cast<std::size_t>(drives);
  }

 private:
  const Drive& drive_;
  const Trajectory& trajectory_;
  ScanNumbers earlier_;
  PointGrid grid_;  // of their places
};

// One in so much of each drive's way.
ScanNumbers thinned(const Drive& drive, const Trajectory& trajectory, const ScanNumbers& scans) {
  ScanNumbers kept;
  for (const std::size_t scan : scans) {
    const bool is_first = kept.empty() || drive.scans[kept.back()].part != drive.scans[scan].part;
    if (is_first ||
        (place_m(trajectory, scan) - place_m(trajectory, kept.back())).norm() >= kStep_m) {
      kept.push_back(scan);
    }
  }
  return kept;
}

ScanNumbers scans_near(const Trajectory& trajectory, const ScanNumbers& scans,
                       const PointGrid& places, double reach_m) {
  ScanNumbers near;
  for (const std::size_t scan : scans) {
    if (places.nearest(place_m(trajectory, scan), reach_m)) near.push_back(scan);
  }
  return near;
}

std::vector<PlacedScan> placed(const Drive& drive, const Trajectory& trajectory,
                               const ScanNumbers& scans) {
  std::vector<PlacedScan> all;
  for (const std::size_t scan : scans) {
    const SensorProfile& sensor = drive.sensor_of(drive.scans[scan]);
    all.push_back({static_cast<std::uint32_t>(scan),
                   trajectory.poses[scan].T_map_vehicle * sensor.T_vehicle_lidar,
                   sensor.min_range_m, sensor.max_range_m, drive.scans[scan].part});
  }
  return all;
}

Result<std::vector<ComparedSquare>> compare(const PassContext& ctx,
                                            const ChooseScansOptions& options,
                                            const ScanStore& store,
                                            const std::vector<PlacedScan>& scans,
                                            std::uint32_t first_new) {
  CarveOptions carve;
  carve.voxel_m = options.voxel_m;
  carve.carve_range_m = kSeenTogether_m;
  const PointGrid origins = origins_of(scans);
  std::vector<PlacedScan> since = scans;
  std::erase_if(since, [&](const PlacedScan& scan) { return scan.part < first_new; });
  const std::vector<TileKey> tiles = tiles_to_look_at(carve, since);
  const auto scans_of = [&](std::size_t part) {
    return scans_of_tile(carve, scans, origins, tiles[part]);
  };
  using OfTile = std::vector<ComparedSquare>;
  RecordWork<OfTile> work;
  work.count = tiles.size();
  work.content = [&](std::size_t part) {
    return content_of_scans(store, scans_of(part), written(tiles[part], first_new));
  };
  work.make = [&](std::size_t part, int /*threads*/) {
    return compare_in_tile(carve, store, scans_of(part), tiles[part], first_new, kSquare_m);
  };
  SIGHTLINE_ASSIGN(const std::vector<OfTile> of_tile, make_parts(ctx, std::move(work)));
  std::vector<ComparedSquare> all;
  for (const OfTile& some : of_tile) all.insert(all.end(), some.begin(), some.end());
  return all;
}

class Squares {
 public:
  Squares(const std::vector<ComparedSquare>& squares, const ChooseScansOptions& options)
      : options_(options) {
    const double voxel_m2 = options.voxel_m * options.voxel_m;
    std::vector<Eigen::Vector3d> confirmed_m;
    std::vector<Eigen::Vector3d> changed_m;
    for (const ComparedSquare& square : squares) {
      const Eigen::Vector3d at_m((square.square.x + 0.5) * kSquare_m,
                                 (square.square.y + 0.5) * kSquare_m, 0.0);
      if (square.changed * voxel_m2 >= options.least_change_m2) changed_m.push_back(at_m);
      confirmed_m.push_back(at_m);
      confirmed_m2_.push_back(square.confirmed * voxel_m2);
    }
    changed_ = PointGrid(changed_m, kCell_m);
    confirmed_ = PointGrid(confirmed_m, kCell_m);
  }

  // Whether what is seen from a place is what was seen before.
  [[nodiscard]] bool confirm(const Eigen::Vector3d& place_m) const {
    const Eigen::Vector3d at_m(place_m.x(), place_m.y(), 0.0);
    if (changed_.nearest(at_m, options_.reach_m)) return false;
    double confirmed_m2 = 0.0;
    confirmed_.visit_within(at_m, kConfirmed_m, [&](const NearPoint& near) {
      confirmed_m2 += confirmed_m2_[near.index];
    });
    return confirmed_m2 >= kLeastConfirmed_m2;
  }

 private:
  static constexpr double kCell_m = 16.0;
  const ChooseScansOptions& options_;
  PointGrid changed_;
  PointGrid confirmed_;
  std::vector<double> confirmed_m2_;
};

}  // namespace

std::vector<OptionField> option_fields(ChooseScansOptions& options) {
  return {
      choice("laid", options.laid,
             "scans that later drives add to an earlier map: those near changes, or all",
             {"changes", "all"}),
      integer(
          "known_drives", options.known_drives,
          "number of drives of the earlier map on the same way after which a place counts as known",
          1, 1000),
      number("reach_m", options.reach_m,
             "largest distance from a change to a scan that is added, m", 1.0, 200.0),
      number("voxel_m", options.voxel_m, "edge length of the compared voxels, m", 0.05, 2.0),
      number("least_change_m2", options.least_change_m2,
             "least area that appeared or disappeared in a square of 4 m, m^2", 0.0, 1000.0)};
}

Result<Trajectory> choose_scans(PassContext& ctx, const ChooseScansOptions& options,
                                const Drive& drive, const Drive& undistorted,
                                const Trajectory& trajectory, const ReleasedPoses& released) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  SIGHTLINE_TRY(check_trajectory_of_drive(undistorted, trajectory));
  Trajectory chosen = trajectory;
  const std::vector<const TrajectoryPose*> poses = poses_of(drive, released);
  ScanNumbers earlier;
  ScanNumbers others;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i] == nullptr) {
      others.push_back(i);
    } else {
      chosen.poses[i].is_laid = poses[i]->is_laid;
      if (poses[i]->is_laid) earlier.push_back(i);
    }
  }
  if (options.laid == LaidScans::kAll || others.empty()) return chosen;
  const KnownWays ways(drive, trajectory, earlier);
  ScanNumbers known;
  for (const std::size_t scan : others) {
    if (ways.know(scan, options.known_drives)) known.push_back(scan);
  }
  if (known.empty()) return chosen;
  const ScanNumbers together =
      scans_near(trajectory, earlier, grid_of(trajectory, known), kSeenTogether_m);
  ScanNumbers asked = thinned(drive, trajectory, together);
  const ScanNumbers since = thinned(drive, trajectory, known);
  asked.insert(asked.end(), since.begin(), since.end());
  SIGHTLINE_ASSIGN(const std::vector<ComparedSquare> compared,
                   compare(ctx, options, *undistorted.store, placed(undistorted, trajectory, asked),
                           drive.scans[others.front()].part));
  const Squares squares(compared, options);
  for (const std::size_t scan : known) {
    chosen.poses[scan].is_laid = !squares.confirm(place_m(trajectory, scan));
  }
  const std::ptrdiff_t left_out =
      std::ranges::count_if(others, [&](std::size_t i) { return !chosen.poses[i].is_laid; });
  if (left_out > 0) {
    ctx.inform(
        concat(left_out, " of ", others.size(),
               " scans of new drives show no change of the earlier map and are not added to it"));
  }
  return chosen;
}

}  // namespace sightline
