#include "passes/matching/matcher.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "formats/symmetric_eigen.h"

// Newton's method with three guards. Far from the optimum the score is not concave: there the
// Hessian's eigenvalues are taken by their size, which turns a step towards a saddle into one away
// from it. Directions that nothing constrains (all points in one plane) get a floor under their
// eigenvalue, so that rounding noise does not become a step. And a step that made the score worse
// is taken back and tried at a quarter of the length.

namespace sightline {
namespace {

// Rotations weigh as the motion of a point at this distance, so that eigenvalues compare.
constexpr double kLeverArm_m = 10.0;
constexpr double kLeastCurvature = 1e-6;  // of the largest eigenvalue
constexpr double kAllowedLoss = 1e-3;     // of the score, in one step
constexpr double kShrink = 0.25;
constexpr double kGrow = 2.0;

// The step that Newton's method on minus the score proposes.
Vector6d newton_step(const MatchScore& at, bool is_quick) {
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 1.0 / kLeverArm_m, 1.0 / kLeverArm_m, 1.0 / kLeverArm_m;
  const Matrix6d curvature = -(scale.asDiagonal() * at.hessian * scale.asDiagonal());
  const Vector6d uphill = scale.cwiseProduct(at.gradient);
  Matrix6d lifted = curvature;
  lifted.diagonal().array() += kLeastCurvature * curvature.diagonal().cwiseAbs().maxCoeff();
  const Eigen::LLT<Matrix6d> cholesky(lifted);
  if (cholesky.info() == Eigen::Success) {
    const Vector6d step = cholesky.solve(uphill);
    return scale.cwiseProduct(step);
  }
  if (is_quick) {
    const Eigen::LDLT<Matrix6d> pivots(curvature);
    const Vector6d sizes = pivots.vectorD().cwiseAbs();
    const double floor = std::max(kLeastCurvature * sizes.maxCoeff(), 1e-300);
    Vector6d step = pivots.transpositionsP() * uphill;
    pivots.matrixL().solveInPlace(step);
    step = step.cwiseQuotient(sizes.cwiseMax(floor)).eval();
    pivots.matrixU().solveInPlace(step);
    step = (pivots.transpositionsP().transpose() * step).eval();
    return scale.cwiseProduct(step);
  }
  const SymmetricEigen<6> eigen = symmetric_eigen<6>(curvature);
  const Vector6d sizes = eigen.values.cwiseAbs();
  const double floor = std::max(kLeastCurvature * sizes.maxCoeff(), 1e-300);
  const Vector6d along = eigen.vectors.transpose() * uphill;
  const Vector6d step = eigen.vectors * along.cwiseQuotient(sizes.cwiseMax(floor));
  return scale.cwiseProduct(step);
}

// Shortened as a whole to at most `share` of the longest step.
Vector6d limited(const Vector6d& step, const MatchLevel& level, double share) {
  const double length_m = step.head<3>().norm();
  const double angle_rad = step.tail<3>().norm();
  double factor = 1.0;
  if (length_m > share * level.max_step_m) factor = share * level.max_step_m / length_m;
  if (angle_rad > share * level.max_step_rad) {
    factor = std::min(factor, share * level.max_step_rad / angle_rad);
  }
  return factor * step;
}

bool is_short(const Vector6d& step, const MatchLevel& level) {
  return step.head<3>().norm() < level.stop_step_m && step.tail<3>().norm() < level.stop_step_rad;
}

void describe(const MatchScore& at, MatchResult& result) {
  result.score = at.score;
  result.scored_points = at.scored_points;
  if (at.scored_points > 0) result.nearest_voxel_likelihood = at.nearest_sum / at.scored_points;
  result.hessian = -at.hessian;
}

void climb(const MatchLevel& level, ScanForMatch& scan, const MatchOptions& options,
           MatchResult& result) {
  const std::size_t count = level.is_thin ? scan.thin_count : scan.points_m.size();
  Pose taken = result.T_map_sensor;
  Pose next = taken;
  MatchScore at_taken;
  double share = 1.0;
  bool is_first = true;
  MatchStop stop = MatchStop::kIterationLimit;
  while (result.iterations < options.max_iterations) {
    const MatchScore at_next = kernel_score(*level.grid, scan, count, next, options.kernel);
    ++result.iterations;
    result.work += count;
    if (is_first && at_next.scored_points == 0) return;
    const bool is_taken = is_first || at_next.score >= (1.0 - kAllowedLoss) * at_taken.score;
    is_first = false;
    share = is_taken ? std::min(1.0, kGrow * share) : kShrink * share;
    if (is_taken) {
      taken = next;
      at_taken = at_next;
    }
    const Vector6d step = limited(newton_step(at_taken, level.has_quick_steps), level, share);
    next = moved(taken, step);
    if (is_short(step, level)) {
      stop = MatchStop::kConverged;
      taken = next;
      break;
    }
  }
  result.stop = stop;
  if (is_first) return;  // no evaluation was left
  result.T_map_sensor = taken;
  describe(at_taken, result);
}

}  // namespace

std::string_view to_text(MatchStop stop) {
  constexpr std::string_view kTexts[] = {"converged", "iteration limit", "no points", "no overlap"};
  return kTexts[static_cast<std::size_t>(stop)];
}

std::optional<Matrix6d> covariance_of(const MatchResult& result) {
  const Eigen::LLT<Matrix6d> cholesky(result.hessian);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  // By columns: of a whole matrix Eigen solves blocks at once, on arm64 by fused products.
  Matrix6d inverse;
  for (int i = 0; i < 6; ++i) inverse.col(i) = cholesky.solve(Vector6d::Unit(i));
  if (!inverse.allFinite()) return std::nullopt;
  return 0.5 * (inverse + inverse.transpose());
}

MatchResult match(const MatchGrid& grid, std::span<const Eigen::Vector3d> points_m,
                  const Pose& T_map_start, const MatchOptions& options) {
  ScanForMatch scan = make_scan_for_match(points_m);
  return match(grid, scan, T_map_start, options);
}

MatchResult match(const MatchGrid& grid, ScanForMatch& scan, const Pose& T_map_start,
                  const MatchOptions& options) {
  const MatchLevel level{.grid = &grid,
                         .max_step_m = options.max_step_m,
                         .max_step_rad = options.max_step_rad,
                         .stop_step_m = options.stop_step_m,
                         .stop_step_rad = options.stop_step_rad};
  return match(std::span(&level, 1), scan, T_map_start, options);
}

MatchResult match(std::span<const MatchLevel> levels, ScanForMatch& scan, const Pose& T_map_start,
                  const MatchOptions& options) {
  MatchResult result;
  result.T_map_sensor = T_map_start;
  if (scan.points_m.empty()) return result;
  result.stop = MatchStop::kNoOverlap;
  for (const MatchLevel& level : levels) climb(level, scan, options, result);
  return result;
}

}  // namespace sightline
