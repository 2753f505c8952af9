#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/matching/kernel_score.h"
#include "passes/trajectory/local/local_map.h"
#include "passes/trajectory/local/wider_starts.h"

// Matching one scan to a local map; part of estimate-trajectory. Poses are the sensor's:
// T_map_lidar.

namespace sightline {

// A scan within its sensor's range, thinned, in the frame of the drive's first sensor.
struct ThinnedScan {
  std::vector<Eigen::Vector3d> to_match_m;
  std::vector<Eigen::Vector3d> to_map_m;  // denser: of local maps
};
// What a scan is thinned for; one use alone takes less time.
enum class ThinnedFor { kBoth, kMatch, kMap };
// Points of other uses stay empty. Errors: those of reading a scan.
Result<ThinnedScan> read_thinned(const Drive& drive, std::size_t index,
                                 ThinnedFor use = ThinnedFor::kBoth);

struct LocalMatch {
  Pose T_map_lidar = Pose::Identity();
  double likelihood = 0.0;    // mean over points of the largest single term of the fine score
  double scored_share = 0.0;  // of the points that have an ND near
  // By likelihood alone, once enough points are scored: the share pulls scans onto each other, ring
  // on ring, whether the vehicle moved or not.
  [[nodiscard]] bool is_better_than(const LocalMatch& other) const;
  [[nodiscard]] bool is_good() const;
  // Stricter, for loops: a false one bends the whole route.
  [[nodiscard]] bool is_sure() const;
};

// The pose with its rotation normalized: products over kilometres drift from being rotations.
Pose tidied(const Pose& pose);

// Coarse, then fine, from one start.
LocalMatch match_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                         const Pose& T_map_start);

// The steps at which a last match stops: short compared with the accuracy of one pose, or with what
// a drive of kilometres adds up.
enum class LastStep { kShort, kShortest };

// A good match refined with thin walls. Without it, a drive of a kilometre bends three times as
// much (16 beams, generated towns).
Pose sharpened(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
               const LocalMatch& found, LastStep last = LastStep::kShort);

// Matches of one scan to one local map from many starts, most of which end in one place: where a
// coarse match ends where an earlier one did, the fine match is left out. Refers to the grids,
// which must not change.
class LocalSearch {
 public:
  LocalSearch(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m);

  // Coarse, then fine; none where an earlier start led to the same end.
  [[nodiscard]] std::optional<LocalMatch> match(const Pose& T_map_start);

 private:
  const LocalGrids& grids_;
  ScanForMatch coarse_;
  ScanForMatch fine_;
  std::vector<Pose> T_map_ends_;  // of coarse matches, all different
};

// Starts 1 m apart, up to `reach_m` around in the sensor's plane.
std::vector<Pose> starts_around(const Pose& T_map_start, double reach_m);

// The best match from all these starts.
LocalMatch search_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                          const Pose& T_map_start, double reach_m);

// A local map: NDs for matching, upright points for the overlap.
struct LocalSurroundings {
  const LocalGrids& grids;
  const UprightMap& upright;
};

// A scan that is looked for.
struct SoughtScan {
  const std::vector<Eigen::Vector3d>& to_match_m;
  const std::vector<Eigen::Vector3d>& upright_m;  // of those, for the overlap
};

struct WidePlacement {
  LocalMatch match;
  double overlap = 0.0;
  // Of the best place more than a match's error away: a place is known only where no other is
  // nearly as good.
  double overlap_elsewhere = 0.0;
};

// Searches all headings and up to the reach around; each of the best starts is matched. None where
// no start ends in a good match.
std::optional<WidePlacement> place_widely(const LocalSurroundings& there, const SoughtScan& scan,
                                          const Pose& T_map_around, const WideSearch& options);

// Matches the scan from given places at headings up to 100 degrees to either side, for a vehicle
// that turned quickly where it was. The first of the places whose overlap is within 0.03 of the
// largest. None where no start ends in a good match.
std::optional<WidePlacement> place_turned(const LocalSurroundings& there, const SoughtScan& scan,
                                          const std::vector<Pose>& T_map_places);

// Whether two poses of one scan are different places.
bool are_elsewhere(const Pose& a, const Pose& b);

}  // namespace sightline
