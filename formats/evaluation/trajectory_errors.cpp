#include "formats/evaluation/trajectory_errors.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "formats/base/statistics.h"

namespace sightline {
namespace {

// Poses of the same time.
struct PosePair {
  Pose reference = Pose::Identity();
  Pose found = Pose::Identity();
};

// The nearest in time, of two equally near the earlier; `poses` are not empty.
const TimedPose& nearest_in_time(std::span<const TimedPose> poses, std::int64_t stamp_ns) {
  const auto after = std::ranges::lower_bound(poses, stamp_ns, {}, &TimedPose::stamp_ns);
  if (after == poses.begin()) return *after;
  const auto before = std::prev(after);
  const bool is_after_nearer =
      after != poses.end() && after->stamp_ns - stamp_ns < stamp_ns - before->stamp_ns;
  return is_after_nearer ? *after : *before;
}

// Each pose of the shorter list with the nearest of the longer one.
std::vector<PosePair> pairs_in_time(std::span<const TimedPose> reference,
                                    std::span<const TimedPose> poses, std::int64_t most_apart_ns) {
  const bool is_reference_longer = reference.size() >= poses.size();
  const std::span<const TimedPose> shorter = is_reference_longer ? poses : reference;
  const std::span<const TimedPose> longer = is_reference_longer ? reference : poses;
  std::vector<PosePair> pairs;
  for (const TimedPose& one : shorter) {
    const TimedPose& other = nearest_in_time(longer, one.stamp_ns);
    if (std::abs(other.stamp_ns - one.stamp_ns) > most_apart_ns) continue;
    pairs.push_back(is_reference_longer ? PosePair{other.T_world_vehicle, one.T_world_vehicle}
                                        : PosePair{one.T_world_vehicle, other.T_world_vehicle});
  }
  return pairs;
}

struct Centres {
  Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d found_m = Eigen::Vector3d::Zero();
};

Centres centres_of(const std::vector<PosePair>& pairs) {
  Centres sum;
  for (const PosePair& pair : pairs) {
    sum.reference_m += pair.reference.translation();
    sum.found_m += pair.found.translation();
  }
  const auto count = static_cast<double>(pairs.size());
  return {sum.reference_m / count, sum.found_m / count};
}

// The motion that takes the found positions nearest to those of the reference (Umeyama 1991,
// without scale).
Result<Pose> aligning(const std::vector<PosePair>& pairs) {
  const Centres centres = centres_of(pairs);
  Eigen::Matrix3d sum_m2 = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    sum_m2 += (pair.reference.translation() - centres.reference_m) *
              (pair.found.translation() - centres.found_m).transpose();
  }
  const Eigen::Matrix3d covariance_m2 = sum_m2 / static_cast<double>(pairs.size());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance_m2,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Two directions are needed: below this the second one is rounding.
  constexpr double kLeastSpread = 1e-12;
  const Eigen::Vector3d spread_m2 = svd.singularValues();
  if (!(spread_m2[1] > kLeastSpread * std::max(spread_m2[0], kLeastSpread))) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat("the ", pairs.size(),
                        " poses to align are on one line or at one place, so their rotation is "
                        "unknown; compare without --align")};
  }
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) mirror(2, 2) = -1.0;
  Pose T_reference_world = Pose::Identity();
  T_reference_world.linear() = svd.matrixU() * mirror * svd.matrixV().transpose();
  T_reference_world.translation() =
      centres.reference_m - T_reference_world.linear() * centres.found_m;
  return T_reference_world;
}

// Those so many poses apart, one behind the other.
std::vector<std::pair<std::size_t, std::size_t>> steps_of_frames(std::size_t count,
                                                                 std::size_t delta) {
  std::vector<std::pair<std::size_t, std::size_t>> steps;
  for (std::size_t i = 0; i + delta < count; i += delta) steps.emplace_back(i, i + delta);
  return steps;
}

// Those so far apart along the poses found.
std::vector<std::pair<std::size_t, std::size_t>> steps_of_metres(const std::vector<PosePair>& pairs,
                                                                 double delta_m) {
  std::vector<std::size_t> ends;
  double driven_m = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1;
    driven_m += (pairs[i].found.translation() - pairs[before].found.translation()).norm();
    if (driven_m < delta_m) continue;
    ends.push_back(i);
    driven_m = 0.0;
  }
  std::vector<std::pair<std::size_t, std::size_t>> steps;
  for (std::size_t i = 1; i < ends.size(); ++i) steps.emplace_back(ends[i - 1], ends[i]);
  return steps;
}

struct ErrorLists {
  std::vector<double> length_m;
  std::vector<double> angle_deg;

  void add(const Pose& expected, const Pose& found) {
    const Pose error = expected.inverse(Eigen::Isometry) * found;
    length_m.push_back(error.translation().norm());
    angle_deg.push_back(rotation_angle_rad(error.linear()) * 180.0 / std::numbers::pi);
  }
};

ErrorLists absolute_errors(const std::vector<PosePair>& pairs) {
  ErrorLists errors;
  for (const PosePair& pair : pairs) errors.add(pair.reference, pair.found);
  return errors;
}

ErrorLists relative_errors(const std::vector<PosePair>& pairs,
                           const TrajectoryErrorOptions& options) {
  const auto steps =
      options.unit == DeltaUnit::kMetres
          ? steps_of_metres(pairs, options.delta)
          : steps_of_frames(pairs.size(),
                            std::max<std::size_t>(1, static_cast<std::size_t>(options.delta)));
  ErrorLists errors;
  for (const auto& [from, to] : steps) {
    errors.add(pairs[from].reference.inverse(Eigen::Isometry) * pairs[to].reference,
               pairs[from].found.inverse(Eigen::Isometry) * pairs[to].found);
  }
  return errors;
}

}  // namespace

ErrorStatistics statistics_of(std::span<const double> errors) {
  ErrorStatistics found;
  if (errors.empty()) return found;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double error : errors) {
    sum += error;
    sum_of_squares += error * error;
  }
  const auto count = static_cast<double>(errors.size());
  found.count = errors.size();
  found.mean = sum / count;
  found.rmse = std::sqrt(sum_of_squares / count);
  double sum_of_deviations = 0.0;
  for (const double error : errors) {
    sum_of_deviations += (error - found.mean) * (error - found.mean);
  }
  found.std = std::sqrt(sum_of_deviations / count);
  std::vector<double> sorted(errors.begin(), errors.end());
  std::ranges::sort(sorted);
  found.median = quantile_of_sorted(sorted, 0.5);
  found.min = sorted.front();
  found.max = sorted.back();
  return found;
}

Result<TrajectoryErrors> trajectory_errors(std::span<const TimedPose> reference,
                                           std::span<const TimedPose> poses,
                                           const TrajectoryErrorOptions& options) {
  std::vector<PosePair> pairs;
  if (!reference.empty() && !poses.empty()) {
    pairs = pairs_in_time(reference, poses, options.most_apart_ns);
  }
  if (pairs.empty()) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat("none of ", poses.size(), " poses has one of the ", reference.size(),
                        " reference poses within ", options.most_apart_ns / 1'000'000,
                        " ms; check that both use the same clock")};
  }
  TrajectoryErrors errors;
  errors.pair_count = pairs.size();
  if (options.is_aligned) {
    SIGHTLINE_ASSIGN(errors.T_reference_world, aligning(pairs));
    for (PosePair& pair : pairs) pair.found = errors.T_reference_world * pair.found;
  }
  const ErrorLists absolute = absolute_errors(pairs);
  const ErrorLists relative = relative_errors(pairs, options);
  errors.absolute_m = statistics_of(absolute.length_m);
  errors.absolute_deg = statistics_of(absolute.angle_deg);
  errors.relative_m = statistics_of(relative.length_m);
  errors.relative_deg = statistics_of(relative.angle_deg);
  return errors;
}

}  // namespace sightline
