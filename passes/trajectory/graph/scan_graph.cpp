#include "passes/trajectory/graph/scan_graph.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "formats/geometry.h"
#include "passes/trajectory/graph/given_steps.h"
#include "passes/trajectory/graph/loops.h"

namespace sightline {
namespace {

// Of one step of odometry; measured on generated towns: about 3 mm and 0.03 degrees.
constexpr double kStepSigma_m = 0.005;
constexpr double kStepSigma_rad = 0.0005;
// Of a step that could not be matched and follows the given poses.
constexpr double kUnmatchedSigma_m = 0.5;
constexpr double kUnmatchedSigma_rad = 0.05;
// Of a step over a gap of the recording: a scan matched to what was measured from far away is off
// by the errors of the beams' directions.
constexpr double kFarSigma_m = 0.2;
constexpr double kFarSigma_rad = 0.01;
// Between key scans; those between follow.
constexpr double kKeyStep_m = 2.0;
constexpr double kKeyTurn_rad = 0.1;

// Errors of given poses vary slowly: poses within this length share theirs, and together weigh as
// much as one.
double shared_by(const EstimateTrajectoryOptions& options, double way_m, std::size_t poses) {
  return std::max(1.0, static_cast<double>(poses) * options.prior_correlation_m /
                           std::max(way_m, options.prior_correlation_m));
}

// Whether the step to a scan is not known.
bool begins_piece(const Odometry& odometry, std::size_t scan) {
  return scan > 0 && odometry.piece[scan] != odometry.piece[scan - 1];
}

bool uses_given_motion(const Odometry& odometry, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t k = from + 1; k <= to; ++k) {
    const StepConstraint& step = odometry.constraint[k];
    if (step.forecast == Forecast::kGiven && !step.forecast_motions.isZero(0.0)) return true;
  }
  return false;
}

// Pose i is that of scans[i].
std::vector<GraphPrior> priors_of(const EstimateTrajectoryOptions& options,
                                  const Odometry& odometry, const GivenPoses& given,
                                  const std::vector<std::uint32_t>& scans) {
  std::vector<GraphPrior> priors;
  for (std::uint32_t i = 0; i < scans.size(); ++i) {
    const std::optional<Pose>& pose = given[scans[i]];
    if (pose) priors.push_back({i, *pose, options.prior_sigma_m, options.prior_sigma_deg});
  }
  const double more = std::sqrt(shared_by(options, odometry.driven_m.back(), priors.size()));
  for (GraphPrior& prior : priors) {
    prior.sigma_m *= more;
    prior.sigma_rad *= more * std::numbers::pi / 180.0;
  }
  return priors;
}

}  // namespace

std::vector<std::uint32_t> all_scans(const Odometry& odometry) {
  std::vector<std::uint32_t> scans(odometry.T_map_lidar.size());
  std::iota(scans.begin(), scans.end(), 0u);
  return scans;
}

std::vector<std::uint32_t> key_scans(const Odometry& odometry) {
  std::vector<std::uint32_t> keys;
  const std::size_t count = odometry.T_map_lidar.size();
  for (std::uint32_t k = 0; k < count; ++k) {
    const bool is_far = keys.empty() ||
                        odometry.driven_m[k] - odometry.driven_m[keys.back()] >= kKeyStep_m ||
                        rotation_angle_rad(odometry.T_map_lidar[keys.back()].linear().transpose() *
                                           odometry.T_map_lidar[k].linear()) >= kKeyTurn_rad;
    const bool is_end = k + 1 == count || begins_piece(odometry, k + 1) || odometry.is_far[k + 1];
    if (is_far || is_end || begins_piece(odometry, k)) keys.push_back(k);
  }
  return keys;
}

std::vector<GraphEdge> steps_of(const Odometry& odometry, const std::vector<std::uint32_t>& scans) {
  std::vector<GraphEdge> steps;
  for (std::uint32_t i = 1; i < scans.size(); ++i) {
    if (odometry.piece[scans[i]] != odometry.piece[scans[i - 1]]) continue;
    bool is_matched = true;
    bool is_far = false;
    for (std::uint32_t k = scans[i - 1] + 1; k <= scans[i]; ++k) {
      is_matched = is_matched && odometry.is_matched[k];
      is_far = is_far || odometry.is_far[k];
    }
    const double count = std::sqrt(static_cast<double>(scans[i] - scans[i - 1]));
    const double sigma_m = count * (is_matched ? kStepSigma_m : kUnmatchedSigma_m);
    const double sigma_rad = count * (is_matched ? kStepSigma_rad : kUnmatchedSigma_rad);
    steps.push_back({i - 1, i,
                     odometry.T_map_lidar[scans[i - 1]].inverse() * odometry.T_map_lidar[scans[i]],
                     is_far ? kFarSigma_m : sigma_m, is_far ? kFarSigma_rad : sigma_rad});
  }
  return steps;
}

KeyGraph graph_of_keys(const PoseGraph& graph, const Odometry& odometry,
                       std::vector<GraphPrior> priors, const std::vector<std::uint32_t>& keys) {
  KeyGraph of_keys;
  of_keys.scans = keys;
  PoseGraph& reduced = of_keys.graph;
  reduced.odometry = steps_of(odometry, keys);
  reduced.priors = std::move(priors);
  const auto key_before = [&](std::uint32_t scan) {
    const auto after = std::ranges::upper_bound(keys, scan);
    return static_cast<std::uint32_t>(after - keys.begin() - 1);
  };
  for (GraphEdge loop : graph.loops) {
    const std::uint32_t from = key_before(loop.from);
    const std::uint32_t to = key_before(loop.to);
    const std::vector<Pose>& poses = odometry.T_map_lidar;
    loop.T_from_to = poses[keys[from]].inverse() * poses[loop.from] * loop.T_from_to *
                     poses[loop.to].inverse() * poses[keys[to]];
    loop.from = from;
    loop.to = to;
    if (from != to) reduced.loops.push_back(loop);
  }
  for (const std::uint32_t scan : graph.held) reduced.held.push_back(key_before(scan));
  return of_keys;
}

PoseGraph graph_of_scans(const EstimateTask& task, const GivenPoses& given,
                         const Odometry& odometry, const Connections& connections) {
  const std::vector<std::uint32_t> scans = all_scans(odometry);
  PoseGraph graph{steps_of(odometry, scans), connections.edges(),
                  priors_of(task.options, odometry, given, scans), connections.pieces.held};
  add_given_drift(task.drive, odometry, given_drift(task.options, given, odometry), scans,
                  graph.odometry);
  return graph;
}

KeyGraph key_graph_of(const EstimateTask& task, const GivenPoses& given, const Odometry& odometry,
                      const PoseGraph& graph, const std::vector<Pose>& solved) {
  const std::vector<std::uint32_t> keys = key_scans(odometry);
  KeyGraph of_keys =
      graph_of_keys(graph, odometry, priors_of(task.options, odometry, given, keys), keys);
  for (GraphEdge& step : of_keys.graph.odometry) {
    const std::uint32_t from = keys[step.from];
    const std::uint32_t to = keys[step.to];
    if (uses_given_motion(odometry, from, to)) step.T_from_to = solved[from].inverse() * solved[to];
  }
  return of_keys;
}

std::vector<GraphEdge> Connections::edges() const {
  std::vector<GraphEdge> all = pieces.edges;
  all.insert(all.end(), loops.begin(), loops.end());
  return all;
}

Result<Connections> connect_scans(const EstimateTask& task, const GivenPoses& given,
                                  Odometry& odometry, const KnownPieces& known) {
  const auto& [ctx, options, drive] = task;
  Connections connections;
  SIGHTLINE_ASSIGN(connections.pieces, join_pieces(ctx, drive, given, odometry, known));
  warn_of_pieces(ctx, drive, odometry, connections.pieces);
  if (!options.closes_loops) return connections;
  LoopSearch search;
  if (known.scans > 0) search = {known.scans, known.scans};
  const std::vector<GraphEdge> steps = steps_of(odometry, all_scans(odometry));
  SIGHTLINE_ASSIGN(connections.loops, find_loops(ctx, drive, odometry, steps, search));
  return connections;
}

bool are_connected(const Odometry& odometry, const std::vector<GraphEdge>& joins,
                   const std::vector<GraphEdge>& loops) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> loop_count;
  for (const GraphEdge& loop : loops) {
    ++loop_count[std::minmax({odometry.piece[loop.from], odometry.piece[loop.to]})];
  }
  std::vector<std::uint32_t> group(odometry.piece_starts.size() + 1);  // by piece
  std::iota(group.begin(), group.end(), 0U);
  for (const auto& [pair, count] : loop_count) {
    if (count < kConnectingLoops) continue;
    std::ranges::replace(group, std::uint32_t{group[pair.second]},
                         std::uint32_t{group[pair.first]});
  }
  return std::ranges::all_of(joins, [&](const GraphEdge& join) {
    return group[odometry.piece[join.from]] == group[odometry.piece[join.to]];
  });
}

}  // namespace sightline
