#include "passes/matching/optimum_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "passes/matching/horizontal_curvature.h"

// Why a search: between two long walls the score has a chain of optima along the street, a metre or
// so apart, and a start a metre off climbs the wrong one. The right one is nearly always the
// highest. The first level's Hessian tells the loose direction, a handful of looks at the blurred
// score along it tell where another optimum is, and the last level's score, of all points, decides
// between the two.

namespace sightline {
namespace {

constexpr double kProbeSpacing_m = 0.3;  // the blurred score's peaks are wider
constexpr int kProbes = 5;               // to each side
constexpr double kWorthTrying = 0.9;     // of the score where the first level ended
constexpr double kSameOptimum_m = 0.15;  // optima nearer than this are one
constexpr double kLeverArm_m = 10.0;     // turns weigh as the motion of a point at this distance

// The horizontal direction that the score constrains least, of length 1, all other motions free to
// follow; nothing where no direction is loose.
std::optional<Eigen::Vector2d> loose_direction(const Matrix6d& hessian, double loose_below) {
  const HorizontalCurvature curvature = horizontal_curvature(hessian);
  if (!(curvature.weak < loose_below * curvature.strong)) return std::nullopt;
  return curvature.weak_direction;
}

// What all parts of one search together took.
struct Effort {
  int iterations = 0;
  std::uint64_t work = 0;
};

MatchResult climb(std::span<const MatchLevel> levels, const Pose& T_map_start,
                  const OptimumSearch& search, ScanForMatch& scan, Effort& effort) {
  const MatchResult result = match(levels, scan, T_map_start, search.options);
  effort.iterations += result.iterations;
  effort.work += result.work;
  return result;
}

Pose shifted(const Pose& pose, const Eigen::Vector2d& shift_m) {
  Pose result = pose;
  result.translation().head<2>() += shift_m;
  return result;
}

// The best of the first level's other optima along a direction, roughly; nothing where there is
// none that is worth trying.
std::optional<Pose> other_optimum(const MatchResult& lead, const Eigen::Vector2d& direction,
                                  const OptimumSearch& search, const Pose& T_map_start,
                                  ScanForMatch& scan, Effort& effort) {
  std::array<double, 2 * kProbes + 1> scores{};
  const auto pose_of = [&](int probe) {
    return shifted(lead.T_map_sensor, probe * kProbeSpacing_m * direction);
  };
  const auto index_of = [](int probe) {
    return static_cast<std::size_t>(std::int64_t{probe} + kProbes);
  };
  for (int probe = -kProbes; probe <= kProbes; ++probe) {
    scores[index_of(probe)] = kernel_score_alone(*search.levels[0].grid, scan, scan.thin_count,
                                                 pose_of(probe), search.options.kernel);
    ++effort.iterations;
    effort.work += scan.thin_count;
  }
  const auto score_of = [&](int probe) {
    return std::abs(probe) > kProbes ? 0.0 : scores[index_of(probe)];
  };
  int best = 0;
  for (int probe = -kProbes; probe <= kProbes; ++probe) {
    const double score = score_of(probe);
    const bool is_peak = score > score_of(probe - 1) && score >= score_of(probe + 1);
    const Eigen::Vector3d off_m = pose_of(probe).translation() - T_map_start.translation();
    if (std::abs(probe) < 2 || !is_peak || off_m.head<2>().norm() > search.search_m) continue;
    if (score > (best == 0 ? kWorthTrying * score_of(0) : score_of(best))) best = probe;
  }
  if (best == 0) return std::nullopt;
  return pose_of(best);
}

// From where the first level ended.
MatchResult go_on(const OptimumSearch& search, const Pose& T_map_start, const MatchResult& lead,
                  ScanForMatch& scan) {
  const std::span<const MatchLevel> first = search.levels.first(1);
  const std::span<const MatchLevel> rest = search.levels.subspan(1);
  Effort effort;
  const std::optional<Eigen::Vector2d> direction =
      lead.scored_points > 0 ? loose_direction(lead.hessian, search.loose_below) : std::nullopt;
  const std::optional<Pose> other =
      direction ? other_optimum(lead, *direction, search, T_map_start, scan, effort) : std::nullopt;
  MatchResult best = climb(rest, lead.T_map_sensor, search, scan, effort);
  if (other) {
    const Pose T_map_other = climb(first, *other, search, scan, effort).T_map_sensor;
    if ((T_map_other.translation() - lead.T_map_sensor.translation()).norm() > kSameOptimum_m) {
      const MatchResult found = climb(rest, T_map_other, search, scan, effort);
      if (found.score > best.score) best = found;
    }
  }
  best.iterations = effort.iterations;
  best.work = effort.work;
  return best;
}

}  // namespace

const SharedClimbs::Climb* SharedClimbs::find(const Pose& T_map_lead) const {
  const auto is_near = [&](const Climb& climb) {
    const double turned = (climb.T_map_lead.linear() - T_map_lead.linear()).norm();
    return (climb.T_map_lead.translation() - T_map_lead.translation()).norm() < kSame_m &&
           kLeverArm_m * turned < kSame_m;
  };
  const auto found = std::ranges::find_if(climbs_, is_near);
  return found == climbs_.end() ? nullptr : &*found;
}

MatchResult search_optimum(const OptimumSearch& search, const Pose& T_map_start, ScanForMatch& scan,
                           SharedClimbs* shared) {
  const MatchResult lead = match(search.levels.first(1), scan, T_map_start, search.options);
  const SharedClimbs::Climb* earlier =
      shared == nullptr || lead.scored_points == 0 ? nullptr : shared->find(lead.T_map_sensor);
  MatchResult best = earlier == nullptr ? go_on(search, T_map_start, lead, scan) : earlier->found;
  if (shared != nullptr && earlier == nullptr && lead.scored_points > 0) {
    shared->add({lead.T_map_sensor, best});
  }
  best.iterations += lead.iterations;
  best.work += lead.work;
  return best;
}

}  // namespace sightline
