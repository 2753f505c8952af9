#include "passes/matching/optimum_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/stopwatch.h"
#include "passes/matching/match_score.h"

// Why a search: between two long walls the score has optima along the street about a metre apart,
// of which the right one is nearly always the highest. The first level's Hessian gives the loose
// direction, its score along that shows another optimum, and the last level's score decides.

namespace sightline {
namespace {

constexpr double kProbeSpacing_m = 0.3;  // the blurred score's peaks are wider
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

MatchResult match_levels(std::span<const MatchLevel> levels, const Pose& T_map_start,
                         const OptimumSearch& search, ScanForMatch& scan, SearchPart& part) {
  const MatchResult result = match(levels, scan, T_map_start, search.options);
  part.iterations += result.iterations;
  part.work += result.work;
  return result;
}

Pose pose_of_probe(const Climb& climb, int probe) {
  Pose pose = climb.T_map_lead;
  pose.translation().head<2>() += probe * kProbeSpacing_m * *climb.loose_direction;
  return pose;
}

std::size_t index_of(int probe) {
  return static_cast<std::size_t>(std::int64_t{probe} + Climb::kProbes);
}

// The score of a probe; 0 beyond the last.
double score_of(const Climb& climb, int probe) {
  return std::abs(probe) > Climb::kProbes ? 0.0 : climb.scores[index_of(probe)];
}

void look_along(const OptimumSearch& search, ScanForMatch& scan, Climb& climb) {
  for (int probe = -Climb::kProbes; probe <= Climb::kProbes; ++probe) {
    climb.scores[index_of(probe)] =
        kernel_score_alone(*search.levels[0].grid, scan, scan.thin_count,
                           pose_of_probe(climb, probe), search.options.kernel);
    ++climb.straight.iterations;
    climb.straight.work += scan.thin_count;
  }
}

// From where the first level ended, whatever the start.
Climb climb_from(const MatchResult& lead, const OptimumSearch& search, ScanForMatch& scan) {
  Climb climb;
  climb.T_map_lead = lead.T_map_sensor;
  if (lead.scored_points > 0) {
    climb.loose_direction = loose_direction(lead.hessian, search.loose_below);
  }
  if (climb.loose_direction) look_along(search, scan, climb);
  climb.straight.found =
      match_levels(search.levels.subspan(1), lead.T_map_sensor, search, scan, climb.straight);
  return climb;
}

// The best of the first level's other optima along the loose direction, roughly; 0 where there is
// none that is worth trying from this start.
int best_probe(const Climb& climb, const Pose& T_map_start, double search_m) {
  int best = 0;
  if (!climb.loose_direction) return best;
  for (int probe = -Climb::kProbes; probe <= Climb::kProbes; ++probe) {
    const double score = score_of(climb, probe);
    const bool is_peak = score > score_of(climb, probe - 1) && score >= score_of(climb, probe + 1);
    const Eigen::Vector3d off_m =
        pose_of_probe(climb, probe).translation() - T_map_start.translation();
    if (std::abs(probe) < 2 || !is_peak || off_m.head<2>().norm() > search_m) continue;
    const double beaten = best == 0 ? kWorthTrying * score_of(climb, 0) : score_of(climb, best);
    if (score > beaten) best = probe;
  }
  return best;
}

// All levels from a probe; finds nothing where the first ends at the optimum that is known.
SearchPart climb_from_probe(const Climb& climb, int probe, const OptimumSearch& search,
                            ScanForMatch& scan) {
  SearchPart part;
  const Pose T_map_other =
      match_levels(search.levels.first(1), pose_of_probe(climb, probe), search, scan, part)
          .T_map_sensor;
  const Eigen::Vector3d apart_m = T_map_other.translation() - climb.T_map_lead.translation();
  if (apart_m.norm() > kSameOptimum_m) {
    part.found = match_levels(search.levels.subspan(1), T_map_other, search, scan, part);
  }
  return part;
}

// The better of two ends, and what all of it took. `other`: null where none was tried.
MatchResult result_of(const MatchResult& lead, const SearchPart& straight,
                      const SearchPart* other) {
  const bool is_other =
      other != nullptr && other->found && other->found->score > straight.found->score;
  MatchResult best = is_other ? *other->found : *straight.found;
  best.iterations = lead.iterations + straight.iterations;
  best.work = lead.work + straight.work;
  if (other != nullptr) {
    best.iterations += other->iterations;
    best.work += other->work;
  }
  return best;
}

}  // namespace

bool SharedClimbs::are_one(const Pose& a, const Pose& b) {
  const double turned = (a.linear() - b.linear()).norm();
  return (a.translation() - b.translation()).norm() < kSame_m && kLeverArm_m * turned < kSame_m;
}

Climb& SharedClimbs::climb_of(const MatchResult& lead, const OptimumSearch& search,
                              ScanForMatch& scan) {
  const auto earlier = std::ranges::find_if(
      climbs_, [&](const Climb& climb) { return are_one(climb.T_map_lead, lead.T_map_sensor); });
  if (earlier != climbs_.end()) {
    taken_over_ms_ += earlier->straight.cpu_ms;
    return *earlier;
  }
  const double begin_ms = thread_cpu_ms();
  climbs_.push_back(climb_from(lead, search, scan));
  climbs_.back().straight.cpu_ms = thread_cpu_ms() - begin_ms;
  return climbs_.back();
}

const SearchPart& SharedClimbs::part_of(int probe, Climb& climb, const OptimumSearch& search,
                                        ScanForMatch& scan) {
  const auto earlier =
      std::ranges::find(climb.from_probes, probe, &std::pair<int, SearchPart>::first);
  if (earlier != climb.from_probes.end()) {
    taken_over_ms_ += earlier->second.cpu_ms;
    return earlier->second;
  }
  const double begin_ms = thread_cpu_ms();
  climb.from_probes.emplace_back(probe, climb_from_probe(climb, probe, search, scan));
  SearchPart& part = climb.from_probes.back().second;
  part.cpu_ms = thread_cpu_ms() - begin_ms;
  return part;
}

MatchResult SharedClimbs::go_on(const MatchResult& lead, const OptimumSearch& search,
                                const Pose& T_map_start, ScanForMatch& scan) {
  taken_over_ms_ = 0.0;
  Climb& climb = climb_of(lead, search, scan);
  const int probe = best_probe(climb, T_map_start, search.search_m);
  if (probe == 0) return result_of(lead, climb.straight, nullptr);
  return result_of(lead, climb.straight, &part_of(probe, climb, search, scan));
}

MatchResult search_optimum(const OptimumSearch& search, const Pose& T_map_start, ScanForMatch& scan,
                           SharedClimbs* shared) {
  const MatchResult lead = match(search.levels.first(1), scan, T_map_start, search.options);
  if (shared != nullptr) return shared->go_on(lead, search, T_map_start, scan);
  const Climb climb = climb_from(lead, search, scan);
  const int probe = best_probe(climb, T_map_start, search.search_m);
  if (probe == 0) return result_of(lead, climb.straight, nullptr);
  const SearchPart other = climb_from_probe(climb, probe, search, scan);
  return result_of(lead, climb.straight, &other);
}

}  // namespace sightline
