#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "formats/geometry.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/matching/kernel_score.h"
#include "passes/matching/match_score.h"

namespace sightline {

// The plain localizer of "Measured error" in schemas/definitions.md.
struct MatchOptions {
  double max_step_m = 0.2;  // a longer step is shortened as a whole
  double max_step_rad = 0.02;
  double stop_step_m = 0.005;  // ends when a step is below both
  double stop_step_rad = 1e-4;
  int max_iterations = 35;
  // A searching localizer looks for another optimum no farther than this from the start, where its
  // own limit is larger.
  double search_m = std::numeric_limits<double>::infinity();
  MatchKernel kernel = MatchKernel::kFastest;
};

enum class MatchStop : std::uint8_t {
  kConverged,
  kIterationLimit,
  kNoPoints,
  kNoOverlap  // no point has an ND near
};
std::string_view to_text(MatchStop stop);

struct MatchResult {
  // The pose of the frame of the scan's points: the sensor's or, in SiteLocalizer and LookMatcher,
  // the vehicle's. The start where nothing could be matched.
  Pose T_map_sensor = Pose::Identity();
  MatchStop stop = MatchStop::kNoPoints;
  int iterations = 0;      // evaluations of score and derivatives
  std::uint64_t work = 0;  // points x iterations: a stand-in for time that never varies
  // At the last pose that was evaluated, a step below the stop limits from T_map_sensor.
  double score = 0.0;
  double nearest_voxel_likelihood = 0.0;  // mean over scored points of the largest single term
  std::uint32_t scored_points = 0;
  Matrix6d hessian = Matrix6d::Zero();  // of minus the score; order dx dy dz wx wy wz, map axes
};

// Inverse of the Hessian. It treats points as independent: it ranks and is no accuracy. Nothing
// where the Hessian is not positive definite.
std::optional<Matrix6d> covariance_of(const MatchResult& result);

// One level of a match from coarse to fine: where it ends the next one starts.
struct MatchLevel {
  const MatchGrid* grid = nullptr;
  bool is_thin = false;  // scores only the scan's leading points, ScanForMatch::thin_count
  double max_step_m = 0.2;
  double max_step_rad = 0.02;
  double stop_step_m = 0.005;
  double stop_step_rad = 1e-4;
  // Where the score is not concave: pivots of an LDLT decomposition instead of eigenvalues.
  bool has_quick_steps = false;
};

// Newton's method on the NDT score from T_map_start. `points_m` are finite, in the frame of the
// pose (sensor or vehicle), cropped and subsampled. Allocates nothing while it iterates.
MatchResult match(const MatchGrid& grid, std::span<const Eigen::Vector3d> points_m,
                  const Pose& T_map_start, const MatchOptions& options = {});

// The same for several starts of one scan, without preparing it anew, on one grid: the scan
// remembers its cells. Allocates nothing.
MatchResult match(const MatchGrid& grid, ScanForMatch& scan, const Pose& T_map_start,
                  const MatchOptions& options = {});

// From coarse to fine: steps and stops are those of the levels, the limit on iterations is of all
// together. A level whose grid has no ND near leaves the pose to the next one; the result describes
// the last that had one. Allocates nothing.
MatchResult match(std::span<const MatchLevel> levels, ScanForMatch& scan, const Pose& T_map_start,
                  const MatchOptions& options = {});

}  // namespace sightline
