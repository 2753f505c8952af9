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

// Matching one scan to a local map; part of estimate-trajectory. Poses here are the sensor's:
// T_map_lidar.

namespace sightline {

// A scan within its sensor's range, thinned, in the frame of the drive's first sensor.
struct ThinnedScan {
  std::vector<Eigen::Vector3d> to_match_m;
  std::vector<Eigen::Vector3d> to_map_m;  // denser: what local maps are made of
};
// What a scan is thinned for; who needs one alone spares the other.
enum class ThinnedFor { kBoth, kMatch, kMap };
// What is not asked for stays empty. Errors: what reading a scan says.
Result<ThinnedScan> read_thinned(const Drive& drive, std::size_t index,
                                 ThinnedFor use = ThinnedFor::kBoth);

struct LocalMatch {
  Pose T_map_lidar = Pose::Identity();
  double likelihood = 0.0;    // mean over points of the largest single term of the fine score
  double scored_share = 0.0;  // of the points that have an ND near
  // By likelihood alone, once enough points speak: the share draws scans onto each other, ring on
  // ring, whether the vehicle moved or not.
  [[nodiscard]] bool is_better_than(const LocalMatch& other) const;
  [[nodiscard]] bool is_good() const;
  // Stricter, where a wrong one would be believed against all others: a false loop bends the whole
  // route.
  [[nodiscard]] bool is_sure() const;
};
// The least likelihood of a good match.
double least_likelihood();

// Rotations that are multiplied for kilometres drift from being rotations.
Pose tidied(const Pose& pose);

// Coarse, then fine, from one start.
LocalMatch match_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                         const Pose& T_map_start);

// Where a last match ends: steps that are short beside what is asked of a pose, or beside what a
// drive of kilometres adds up.
enum class LastStep { kShort, kShortest };

// A match that is believed, to the last centimetre. A drive of a kilometre bends by a third of what
// it does without (16 beams, generated towns).
Pose sharpened(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
               const LocalMatch& found, LastStep last = LastStep::kShort);

// Matches of one scan to one local map from many starts, of which most end alike: where the coarse
// match of a start ends where an earlier one's did, the fine one is not made again. Holds the
// grids, which must stay as they are.
class LocalSearch {
 public:
  LocalSearch(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m);

  // As match_locally(); none where an earlier start led there.
  [[nodiscard]] std::optional<LocalMatch> match(const Pose& T_map_start);

 private:
  const LocalGrids& grids_;
  ScanForMatch coarse_;
  ScanForMatch fine_;
  std::vector<Pose> T_map_ends_;  // of coarse matches, all different
};

// Starts 1 m apart, up to `reach_m` around in the sensor's plane.
std::vector<Pose> starts_around(const Pose& T_map_start, double reach_m);

// Matched locally from each of them; the best end.
LocalMatch search_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                          const Pose& T_map_start, double reach_m);

}  // namespace sightline
