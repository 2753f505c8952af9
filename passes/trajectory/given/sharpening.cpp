#include "passes/trajectory/given/sharpening.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/parallel.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/trajectory/local/scan_constraint.h"

namespace sightline {
namespace {

constexpr double kStretch_m = 50.0;
constexpr double kWindow_m = 10.0;
// Errors of good positions jump from scan to scan; a drift persists for longer than this.
constexpr double kSlow_m = 3.0;
// Matching is off by 0.04 degrees and less over 10 m, and by 2 cm where a street has corners; where
// it has none, by 10 cm and more along the walls (measured on generated towns).
constexpr double kAllowed_rad = 0.2 * std::numbers::pi / 180.0;
constexpr double kAllowed_m = 0.1;
// A matched motion may be off by so many of its standard deviations.
constexpr double kSigmas = 3.0;
// Positions off by 2 cm and 0.04 degrees, as good ones are, cost 0.2 nat on a generated street,
// most of it by their headings; refining exact poses gains up to 0.06.
constexpr double kLeastGain_nat = 0.1;
// The plane variance is more of trees and cars than of walls, and noise below this.
constexpr double kVarianceNoise = 0.02;

// Sums over one stretch, or several.
struct Sums {
  double entropy_nat = 0.0;
  double entropy_points = 0.0;
  double variance_m2 = 0.0;
  double plane_points = 0.0;

  void add(const SharpnessFigures& figures) {
    entropy_nat += figures.mean_entropy_nat * static_cast<double>(figures.entropy_points);
    entropy_points += static_cast<double>(figures.entropy_points);
    variance_m2 += figures.mean_plane_variance_m2 * static_cast<double>(figures.plane_points);
    plane_points += static_cast<double>(figures.plane_points);
  }
  [[nodiscard]] MeanSharpness mean() const {
    return {entropy_nat / std::max(entropy_points, 1.0), variance_m2 / std::max(plane_points, 1.0)};
  }
};

using Points = std::vector<Eigen::Vector3d>;

struct SeenScan {
  std::uint32_t scan = 0;
  Points points_m;
};

Result<Points> near_points_m(const Drive& drive, std::uint32_t scan, double reach_m) {
  SIGHTLINE_ASSIGN(ThinnedScan thinned, read_thinned(drive, scan, ThinnedFor::kMap));
  std::erase_if(thinned.to_map_m,
                [&](const Eigen::Vector3d& point_m) { return point_m.norm() > reach_m; });
  return std::move(thinned.to_map_m);
}

// One scan in so much of the way, near returns only.
Result<std::vector<SeenScan>> scans_of(const PassContext& ctx, const Drive& drive,
                                       const WayStretch& stretch, const std::vector<Pose>& poses) {
  const MeasureSharpnessOptions options;
  std::vector<SeenScan> taken;
  for (std::uint32_t k = stretch.first; k <= stretch.last; ++k) {
    const bool is_far =
        taken.empty() || (poses[k].translation() - poses[taken.back().scan].translation()).norm() >=
                             options.scan_step_m;
    if (is_far) taken.push_back({k, {}});
  }
  SIGHTLINE_ASSIGN(std::vector<Points> near_m,
                   parallel_results<Points>(taken.size(), ctx.threads, [&](std::size_t i) {
                     return near_points_m(drive, taken[i].scan, options.reach_m);
                   }));
  for (std::size_t i = 0; i < taken.size(); ++i) taken[i].points_m = std::move(near_m[i]);
  return taken;
}

template <class PoseOf>
SharpnessFigures sharpness_by(const std::vector<SeenScan>& scans, int threads,
                              const PoseOf& pose_of) {
  std::vector<Eigen::Vector3d> points_m;
  for (const SeenScan& seen : scans) {
    const Pose T_map_lidar = pose_of(seen.scan);
    for (const Eigen::Vector3d& point_m : seen.points_m) points_m.push_back(T_map_lidar * point_m);
  }
  return sharpness_of(points_m, {}, threads);
}

// A refined pose moved by the mean difference to the given ones over 3 m before and after, in the
// doubtful direction: a drift without what jumps from scan to scan.
Pose drifted(const WayStretch& stretch, const GivenPoses& given, const std::vector<Pose>& refined,
             std::uint32_t scan) {
  const auto is_near = [&](std::uint32_t k) {
    return (refined[k].translation() - refined[scan].translation()).norm() <= kSlow_m;
  };
  std::uint32_t first = scan;
  std::uint32_t last = scan;
  while (first > 0 && is_near(first - 1)) --first;
  while (last + 1 < refined.size() && is_near(last + 1)) ++last;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (std::uint32_t k = first; k <= last; ++k) {
    mean_m += (given[k]->translation() - refined[k].translation()) / (last - first + 1.0);
  }
  const Eigen::Vector3d way =
      (refined[last].translation() - refined[first].translation()).normalized();
  const Eigen::Vector3d along_m = mean_m.dot(way) * way;
  Pose moved = refined[scan];
  if (stretch.moves_along) moved.translation() += along_m;
  if (stretch.moves_aside) moved.translation() += mean_m - along_m;
  return moved;
}

void measure_motion(const GivenPoses& given, const Odometry& odometry, WayStretch& stretch) {
  double along_m2 = 0.0;
  double aside_m2 = 0.0;
  double square_rad2 = 0.0;
  double variance_m2 = 0.0;
  double count = 0.0;
  std::uint32_t last = stretch.first;
  for (std::uint32_t first = stretch.first; first <= stretch.last; ++first) {
    last = std::max(last, first);
    const auto way_m = [&] { return odometry.driven_m[last] - odometry.driven_m[first]; };
    while (last + 1 < given.size() && way_m() < kWindow_m) ++last;
    if (way_m() < 0.5 * kWindow_m && count > 0.0) break;
    if (!is_constrained_through(odometry, first, last)) continue;
    const MotionPair motion = motion_between(given, odometry, first, last);
    const Eigen::Vector3d off_m = motion.given.translation() - motion.matched.translation();
    const double along_m = off_m.dot(motion.matched.translation().normalized());
    along_m2 += along_m * along_m;
    aside_m2 += off_m.squaredNorm() - along_m * along_m;
    square_rad2 += motion.off_rad() * motion.off_rad();
    for (std::uint32_t k = first + 1; k <= last; ++k) {
      variance_m2 += odometry.constraint[k].sigma_m * odometry.constraint[k].sigma_m;
    }
    count += 1.0;
  }
  if (count == 0.0) return;
  stretch.along_m = std::sqrt(along_m2 / count);
  stretch.aside_m = std::sqrt(aside_m2 / count);
  stretch.off_rad = std::sqrt(square_rad2 / count);
  stretch.sigma_m = std::sqrt(variance_m2 / count);
}

}  // namespace

std::vector<WayStretch> stretches_of(const GivenPoses& given, const Odometry& odometry,
                                     const std::vector<PoseDisagreement>& disagreements) {
  std::vector<WayStretch> stretches;
  for (std::uint32_t k = 0; k < given.size(); ++k) {
    const bool is_full =
        stretches.empty() ||
        odometry.driven_m[k] - odometry.driven_m[stretches.back().first] >= kStretch_m;
    if (is_full) stretches.push_back({k, k});
    stretches.back().last = k;
  }
  for (WayStretch& stretch : stretches) {
    measure_motion(given, odometry, stretch);
    const double error_m = kSigmas * stretch.sigma_m;
    stretch.turns_otherwise = stretch.off_rad > kAllowed_rad + error_m / kTurnArm_m;
    stretch.moves_along = stretch.along_m > kAllowed_m + error_m;
    stretch.moves_aside = stretch.aside_m > kAllowed_m + error_m;
    for (const PoseDisagreement& found : disagreements) {
      if (found.last >= stretch.first && found.first <= stretch.last)
        stretch.moves_along = stretch.moves_aside = true;
    }
  }
  return stretches;
}

bool is_doubtful(const WayStretch& stretch) {
  return stretch.turns_otherwise || stretch.moves_along || stretch.moves_aside;
}

Result<Sharpening> compare_sharpness(PassContext& ctx, const Drive& drive,
                                     const std::vector<WayStretch>& stretches,
                                     const GivenPoses& given, const std::vector<Pose>& refined) {
  Sums all_given;
  Sums all_refined;
  Sums doubtful_given;
  Sums doubtful_refined;
  for (const WayStretch& stretch : stretches) {
    SIGHTLINE_ASSIGN(const std::vector<SeenScan> scans, scans_of(ctx, drive, stretch, refined));
    const SharpnessFigures as_given =
        sharpness_by(scans, ctx.threads, [&](std::uint32_t k) -> Pose { return *given[k]; });
    const SharpnessFigures as_refined =
        sharpness_by(scans, ctx.threads, [&](std::uint32_t k) -> Pose { return refined[k]; });
    all_given.add(as_given);
    all_refined.add(as_refined);
    if (!is_doubtful(stretch)) continue;
    doubtful_refined.add(as_refined);
    doubtful_given.add(stretch.turns_otherwise
                           ? as_given
                           : sharpness_by(scans, ctx.threads, [&](std::uint32_t k) -> Pose {
                               return drifted(stretch, given, refined, k);
                             }));
  }
  Sharpening found{all_given.mean(), all_refined.mean()};
  found.doubtful_given_nat = doubtful_given.mean().entropy_nat;
  found.doubtful_refined_nat = doubtful_refined.mean().entropy_nat;
  found.is_sharper =
      found.doubtful_refined_nat <= found.doubtful_given_nat - kLeastGain_nat &&
      found.refined.entropy_nat <= found.given.entropy_nat &&
      found.refined.plane_variance_m2 <= (1.0 + kVarianceNoise) * found.given.plane_variance_m2;
  return found;
}

}  // namespace sightline
