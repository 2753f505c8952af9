#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/look.h"
#include "passes/matching/localizer.h"
#include "passes/matching/scan_cutter.h"

namespace sightline {

// Of `count` returns, one in so many is looked at, so that about return_count of them are; see
// even_stride().
double look_stride(const Look& look, std::size_t count);

// Cuts one scan after another by a look and keeps its memory. One thread at a time.
class LookCutter {
 public:
  explicit LookCutter(double leaf_m = 1.0) : leaf_m_(leaf_m) {}

  // Fills `cut` with the points that are matched, in the vehicle's frame. Where the look goes by
  // normals, T_map_start, the pose from which the match starts, says which part of the map each
  // return lies in. Allocates nothing once scans of this size were cut, unless the look takes every
  // return.
  void cut(const Localizer& localizer, const Scan& scan, const SensorProfile& sensor,
           const Look& look, const Pose& T_map_start, ScanForMatch& cut);

  // The same in two steps, for a look that takes a sample: what no start changes, then the rest.
  void prepare(const Scan& scan, const Look& look);
  void finish(const Localizer& localizer, const SensorProfile& sensor, const Pose& T_map_start,
              ScanForMatch& cut);

  // The same, the points alone, in the sensor's frame: of the returns number floor(n stride) those
  // within the range that chance keeps, the first of each voxel floor(x / leaf), in their order.
  // Valid until the next call. The look takes a sample.
  std::span<const Eigen::Vector3d> candidates(std::span<const Eigen::Vector3d> points_m,
                                              const Look& look);

 private:
  void keep_first_of_voxels();
  void keep_spread(std::size_t point_count);
  void classify(const MatchGrid& grid, const Pose& T_map_lidar);
  void take_by_normals(const Localizer& localizer, const Pose& T_map_lidar);

  double leaf_m_;
  ScanCutter dense_;
  std::vector<Eigen::Vector3d> points_m_;  // the first count_
  std::size_t count_ = 0;
  std::size_t most_ = 0;        // points that the look prepared for takes
  bool is_by_normals_ = false;  // that look
  std::vector<Eigen::Vector3d> taken_m_;
  std::vector<std::uint64_t> slots_;    // of voxels; 0: free
  std::vector<std::uint8_t> bins_;      // of points: their direction and distance
  std::vector<CellKey> keys_;           // of points: their cells of the map
  std::vector<std::uint32_t> records_;  // and the numbers of their records
};

// How scans are cut and matched by all code that localizes by looks.
struct LookMatching {
  const Localizer& own;         // for looks that take every return
  const Localizer& of_samples;  // for the others
  const SensorProfile& sensor;
  double leaf_m = 1.0;
  bool takes_every_return = false;  // within a range, as ScanCut says
  // Starts of one scan take over what earlier ones found, where the cut does not depend on them.
  bool shares_climbs = false;
};

// Localizes one scan after the other, for measure-error and for vehicles, so that a map's errors
// are the vehicle's own. One thread at a time. What `matching` refers to must outlive it.
class LookMatcher {
 public:
  explicit LookMatcher(const LookMatching& matching)
      : matching_(matching),
        own_(&matching.own),
        sampled_(&matching.of_samples),
        cutter_(matching.leaf_m) {}

  // From the next scan on, matches in these localizers, made for the same options.
  void use(const Localizer& own, const Localizer& sampled) {
    own_ = &own;
    sampled_ = &sampled;
  }

  // The scan to be matched next, cut as far as no start changes it. What a look takes of it may
  // depend on the start: then match() cuts the rest.
  void take(const Scan& scan, const Look& look);

  // Of the scan taken last; T_map_sensor is the vehicle's pose. Another optimum is looked for no
  // farther than `search_m` from the start, where the localizer would look farther.
  MatchResult match(const Pose& T_map_start,
                    double search_m = std::numeric_limits<double>::infinity());

  // The score at a pose, which stays, in the finest level that a match of this look ends in.
  MatchResult score(const Pose& T_map_vehicle);

  // Of the last match.
  [[nodiscard]] std::size_t point_count() const { return cut_.points_m.size(); }
  // As it was matched, in the vehicle's frame; valid until the next match.
  [[nodiscard]] const ScanForMatch& scan() const { return cut_; }
  [[nodiscard]] double taken_over_ms() const { return climbs_.taken_over_ms(); }  // SharedClimbs'

 private:
  LookMatching matching_;
  const Localizer* own_;
  const Localizer* sampled_;
  ScanCutter near_cutter_;
  LookCutter cutter_;
  ScanForMatch cut_;
  SharedClimbs climbs_;  // of this cut
  Look look_;
};

}  // namespace sightline
