#include "passes/replay/find_place.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "formats/base/parallel.h"
#include "passes/replay/pose_rows.h"
#include "passes/trajectory/local/local_match.h"

namespace sightline {
namespace {

// Poses along a smooth wall have 0.99 of the right one's likelihood. Of two places that are the
// same but for where cells cut them, the wrong one can be the likelier: the other then has 0.84 to
// 0.91.
constexpr double kMostElsewhere = 0.8;
// Right places have 2.8 and more in generated worlds; places in another world up to 2.
constexpr double kLeastLikelihood = 2.2;

// All starts are matched with so many points first, and so many of their ends with all.
constexpr std::uint32_t kFewReturns = 4096;
constexpr std::uint32_t kFewPoints = 256;
constexpr std::size_t kMostMatched = 16;

struct Candidate {
  sightline_match match{};
  Pose T_world_vehicle = Pose::Identity();
  double met_share = -1.0;  // below 0: no match
};

// Mean over all points: one without a surface near has none.
double likelihood_of(const Candidate& candidate) {
  const sightline_match& match = candidate.match;
  const double points = std::max(1.0, static_cast<double>(match.point_count));
  return match.nearest_voxel_likelihood * match.scored_points / points;
}

// A scan, and how it is matched.
struct Tries {
  const SearchedMap& map;
  const Scan& scan;
  const std::vector<Eigen::Vector3d>& upright_m;
  MapLook look;
};

Result<Candidate> candidate_from(const Tries& tries, const Pose& T_world_start) {
  Candidate candidate;
  SIGHTLINE_ASSIGN(candidate.match, tries.map.localizer.match(points_of(tries.scan),
                                                              rows_of(T_world_start), tries.look));
  if (!has_matched(candidate.match)) return candidate;
  candidate.T_world_vehicle = pose_of(candidate.match.T_world_vehicle);
  candidate.met_share =
      tries.map.check.met_share(tries.upright_m, candidate.T_world_vehicle).value_or(-1.0);
  return candidate;
}

// Those that end somewhere.
Result<std::vector<Candidate>> candidates_from(const Tries& tries, const std::vector<Pose>& starts,
                                               int threads) {
  std::vector<Result<Candidate>> tried(starts.size(), Candidate{});
  parallel_for(starts.size(), threads,
               [&](std::size_t i) { tried[i] = candidate_from(tries, starts[i]); });
  std::vector<Candidate> candidates;
  for (Result<Candidate>& one : tried) {
    SIGHTLINE_ASSIGN(const Candidate candidate, std::move(one));
    if (candidate.met_share >= 0.0) candidates.push_back(candidate);
  }
  return candidates;
}

// The first that end in places that are not those of earlier ones.
std::vector<Pose> distinct_ends(const std::vector<Candidate>& candidates) {
  std::vector<Pose> ends;
  for (const Candidate& candidate : candidates) {
    if (ends.size() == kMostMatched) break;
    const bool is_new = std::ranges::none_of(
        ends, [&](const Pose& end) { return !are_elsewhere(end, candidate.T_world_vehicle); });
    if (is_new) ends.push_back(candidate.T_world_vehicle);
  }
  return ends;
}

}  // namespace

bool is_sure(const FoundPlace& place) {
  return place.likelihood >= kLeastLikelihood &&
         place.likelihood_elsewhere <= kMostElsewhere * place.likelihood;
}

FoundPlace likelier_of(const FoundPlace& first, const FoundPlace& second) {
  const bool is_second = second.likelihood > first.likelihood;
  FoundPlace best = is_second ? second : first;
  const FoundPlace& other = is_second ? first : second;
  const bool is_elsewhere =
      are_elsewhere(pose_of(other.match.T_world_vehicle), pose_of(best.match.T_world_vehicle));
  best.likelihood_elsewhere = std::max(
      best.likelihood_elsewhere, is_elsewhere ? other.likelihood : other.likelihood_elsewhere);
  return best;
}

Result<std::optional<FoundPlace>> find_place(const SearchedMap& map, const Scan& scan,
                                             const std::vector<Eigen::Vector3d>& upright_m,
                                             int threads) {
  const std::vector<Pose> starts = map.finder.likely_places(upright_m, threads);
  MapLook few = map.look;
  few.return_count = kFewReturns;
  few.point_count = kFewPoints;
  SIGHTLINE_ASSIGN(std::vector<Candidate> first,
                   candidates_from({map, scan, upright_m, few}, starts, threads));
  std::ranges::stable_sort(first, std::greater(), &likelihood_of);
  SIGHTLINE_ASSIGN(
      const std::vector<Candidate> candidates,
      candidates_from({map, scan, upright_m, map.look}, distinct_ends(first), threads));
  if (candidates.empty()) return std::optional<FoundPlace>();
  const Candidate& best = *std::ranges::max_element(candidates, {}, &likelihood_of);
  FoundPlace found{best.match, best.met_share, likelihood_of(best), 0.0};
  for (const Candidate& other : candidates) {
    if (!are_elsewhere(other.T_world_vehicle, best.T_world_vehicle)) continue;
    found.likelihood_elsewhere = std::max(found.likelihood_elsewhere, likelihood_of(other));
  }
  return std::optional(found);
}

}  // namespace sightline
