#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/annotation/drive_tracks.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/grid/point_grid.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_plan.h"
#include "passes/matching/scan_cutter.h"
#include "passes/pass/options.h"

namespace sightline {

// A pause between two scans after which a vehicle's speed no longer predicts its pose.
inline constexpr std::int64_t kLongestStep_ns = 2'000'000'000;

// A drive in the frame of the map that its scans are matched with.
struct DriveOnMap {
  const Drive& drive;
  Trajectory in_map;
  PointGrid places;                // of the sites' sensors
  double reach_m = 0.0;            // a site farther away says nothing
  std::vector<std::size_t> scans;  // that are matched: indices into the drive, in time order

  // Where the sensor is when the vehicle is at a pose.
  [[nodiscard]] Eigen::Vector3d sensor_m(const Pose& T_map_vehicle) const {
    return T_map_vehicle * drive.sensor.T_vehicle_lidar.translation();
  }
  // The nearest site to a vehicle at a pose, on its level; none where no site is within reach.
  [[nodiscard]] std::optional<std::size_t> site_near(const Pose& T_map_vehicle) const {
    const std::optional<NearPoint> site = places.nearest_on_level(sensor_m(T_map_vehicle), reach_m);
    return site ? std::optional<std::size_t>(site->index) : std::nullopt;
  }
  // From the scan before a position in `scans` to the scan there; 0 at the first.
  [[nodiscard]] std::int64_t step_ns(std::size_t position) const {
    if (position == 0) return 0;
    return drive.scans[scans[position]].stamp_ns - drive.scans[scans[position - 1]].stamp_ns;
  }
};

// With the scans of a selection. Errors: mismatched-inputs (trajectory and drive, or map, sites and
// ranges, do not belong together), empty-map.
inline Result<DriveOnMap> place_on_map(const Drive& drive, const Trajectory& trajectory,
                                       const TiledNds& nds, const Sites& sites,
                                       const RangeTable& ranges, double reach_m,
                                       ScanSelection selection) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  if (!(nds.head().frame == sites.frame) || ranges.site_count != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs, "map, sites and ranges are not of the same compile"};
  }
  if (nds.row_count() == 0) {
    return Error{ErrorCode::kEmptyMap, "the map has no valid cell to match with"};
  }
  DriveOnMap placed{
      drive, rebase(trajectory, nds.head().frame), PointGrid(positions_m(sites)), reach_m, {}};
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (is_selected(drive.scans[i], selection)) placed.scans.push_back(i);
  }
  return placed;
}

// The option "reach_m" of passes that ask a map, which the plan sets.
inline OptionField reach_option(double& reach_m) {
  return shared(number("reach_m", reach_m,
                       "largest distance from a position to the site that answers for it, m", 0.1,
                       1000.0));
}

// What all replays of a drive share. `own` serves ranges, `of_samples` looks that take a sample.
struct TrackInputs {
  const DriveOnMap& placed;
  const ByFamily<RangeTable>& ranges;
  const Localizer& own;
  const Localizer& of_samples;
  double leaf_m = 1.0;
  bool takes_every_return = false;  // within a range, as ScanCut says
};

// Every way to choose how to look that a map offers, and those that need none: its looks and its
// ranges, each everywhere.
std::vector<TrackRule> track_rules(const ByFamily<RangeTable>& ranges);

// How one rule finds its vehicle, scan by scan. One thread at a time.
class TrackMatcher {
 public:
  // The rule is of the inputs' ranges.
  TrackMatcher(const TrackInputs& inputs, const TrackRule& rule);

  struct Found {
    MatchResult match;
    double range_m = 0.0;  // of the look that stands
    bool took_second = false;
  };
  // The map's answer is looked up at the predicted pose, as in a vehicle.
  Found match(const Scan& scan, const PosePrediction& prediction);

 private:
  [[nodiscard]] Look look_at(const Pose& T_map_vehicle) const;
  Found match_range(const Scan& scan, double range_m, const Pose& T_map_start);
  Found match_plan(const Scan& scan, const LookPlan& plan, const PosePrediction& prediction);

  TrackInputs inputs_;
  TrackRule rule_;
  std::size_t limit_ = 0;  // of the map, that the rule is served by
  ScanCutter cutter_;
  LookMemory memory_;
};

}  // namespace sightline
