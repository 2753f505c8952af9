#include "passes/matching/look_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"
#include "formats/geometry.h"
#include "passes/matching/match_score.h"

// Why the test can be linear and small: a first look fails in two ways, and each shows in its
// match. Where one direction is loose, its curvature is low and the match slides away from the
// predicted pose. Where the prediction is wrong, as at the entry of a bend, whose seven degrees are
// beyond what Newton's method climbs, the score is half of the usual.
//
// Why the second look stands alone where it was asked for: joined with the first by their Hessians
// it is no better, and rules that keep what moved less, or the predicted pose, go on with an error
// where the forecast is what went wrong (tests/bench/README.md, "Driving").

namespace sightline {
namespace {

constexpr int kHeadings = 5;  // to each side
constexpr double kHeadingStep_rad = 2.0 * std::numbers::pi / 180.0;

// Of the headings that the blurred score of the leading points likes best, the least turned.
Pose best_heading(const PlannedLocalizer& planned, ScanForMatch& cut, const Pose& T_map_vehicle,
                  PlannedMatch& result) {
  const MatchGrid& widest = *planned.localizer.levels.front().grid;
  Pose best = T_map_vehicle;
  double best_score = 0.0;
  for (int i = 0; i <= 2 * kHeadings; ++i) {
    const int step = (i + 1) / 2 * (i % 2 == 0 ? 1 : -1);  // 0, -1, 1, -2, 2, ..
    Pose pose = T_map_vehicle;  // turned about the vertical, at the vehicle's own place
    pose.linear() = rotation_matrix({Eigen::Vector3d::UnitZ(), step * kHeadingStep_rad}) *
                    T_map_vehicle.linear();
    const double score =
        kernel_score_alone(widest, cut, cut.thin_count, pose, planned.options.kernel);
    ++result.match.iterations;
    result.match.work += cut.thin_count;
    if (score > best_score) {
      best = pose;
      best_score = score;
    }
  }
  return best;
}

MatchResult match_as(LookMode mode, const PlannedLocalizer& planned, ScanForMatch& cut,
                     const Pose& T_map_start) {
  return mode == LookMode::kSettle ? settle(planned.localizer, cut, T_map_start, planned.options)
                                   : localize(planned.localizer, cut, T_map_start, planned.options);
}

bool has_matched(const MatchResult& match) {
  return match.stop != MatchStop::kNoPoints && match.stop != MatchStop::kNoOverlap;
}

// What it finds stands; iterations and work are added to.
void look_first(const PlannedLocalizer& planned, const Scan& scan, const Pose& T_map_start,
                LookMemory& memory, PlannedMatch& result) {
  const Look& look = planned.plan.first;
  memory.cutter.cut(planned.localizer, scan, planned.sensor, look, T_map_start, memory.cut);
  result.match = match_as(look.mode, planned, memory.cut, T_map_start);
  result.look_count = 1;
  result.T_map_first = result.match.T_map_sensor;
  result.signs = look_signs(result.match, memory.cut.points_m.size(), T_map_start);
  result.doubt = doubt_of(planned.plan.test, result.signs);
}

void look_again(const PlannedLocalizer& planned, const Scan& scan, const PosePrediction& prediction,
                LookMemory& memory, PlannedMatch& result) {
  const Look& look = planned.plan.second;
  Pose T_map_start = prediction.T_map_vehicle;
  memory.cutter.cut(planned.localizer, scan, planned.sensor, look, T_map_start, memory.cut);
  if (prediction.is_tracking && !memory.cut.points_m.empty()) {
    T_map_start = best_heading(planned, memory.cut, T_map_start, result);
  }
  const LookMode mode = prediction.is_tracking ? look.mode : LookMode::kSearch;
  MatchResult found = match_as(mode, planned, memory.cut, T_map_start);
  found.iterations += result.match.iterations;
  found.work += result.match.work;
  if (result.look_count == 0 || has_matched(found)) {
    result.match = found;
  } else {
    result.match.iterations = found.iterations;
    result.match.work = found.work;
  }
  ++result.look_count;
}

// A match differs by so much from its prediction in any case, and no direction is looser.
constexpr double kLeastMotion_m = 0.01;
constexpr double kLeastTurn_rad = 0.001;
constexpr double kLeastCurvature_per_m2 = 0.1;

}  // namespace

PlannedMatch localize_in_looks(const PlannedLocalizer& planned, const Scan& scan,
                               const PosePrediction& prediction, LookMemory& memory,
                               const LookDeadline& deadline) {
  PlannedMatch result;
  if (prediction.is_tracking) {
    look_first(planned, scan, prediction.T_map_vehicle, memory, result);
    if (has_matched(result.match) && result.doubt <= planned.plan.doubt_above) return result;
    result.is_past_deadline = deadline.now_ms && deadline.now_ms() > deadline.latest_ms;
    if (result.is_past_deadline) return result;
  }
  look_again(planned, scan, prediction, memory, result);
  return result;
}

LookSigns look_signs(const MatchResult& match, std::size_t point_count,
                     const Pose& T_map_predicted) {
  const double count = static_cast<double>(std::max<std::size_t>(point_count, 1));
  const double scored = std::max(1.0, static_cast<double>(match.scored_points));
  const HorizontalCurvature curvature = horizontal_curvature(match.hessian);
  const auto log_sigma = [](double curvature_per_m2) {
    return -0.5 * portable_log(std::max(curvature_per_m2, kLeastCurvature_per_m2));
  };
  const Eigen::Vector3d moved_m = match.T_map_sensor.translation() - T_map_predicted.translation();
  const double along_m = std::abs(curvature.weak_direction.dot(moved_m.head<2>()));
  const double across_m = std::sqrt(std::max(0.0, moved_m.squaredNorm() - along_m * along_m));
  const Eigen::Matrix3d turn = T_map_predicted.linear().transpose() * match.T_map_sensor.linear();
  return {log_sigma(curvature.weak),
          log_sigma(curvature.strong),
          static_cast<double>(match.scored_points) / count,
          match.score / scored,
          match.nearest_voxel_likelihood,
          portable_log(along_m + kLeastMotion_m),
          portable_log(across_m + kLeastMotion_m),
          portable_log(rotation_angle_rad(turn) + kLeastTurn_rad)};
}

}  // namespace sightline
