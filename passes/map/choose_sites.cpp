#include "passes/map/choose_sites.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "formats/base/level.h"
#include "formats/base/statistics.h"
#include "formats/drive/trajectory.h"
#include "formats/grid/point_grid.h"
#include "formats/text/numbers.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
namespace {

// Standing at a light adds noise, not route.
constexpr double kSmallestStep_m = 0.1;
// A site that rounding puts this far behind a run's end still belongs to it: 100 steps of 0.1 m are
// to make 10 m.
constexpr double kRounding_m = 1e-9;

// A way is another visit of a place that it comes back to after so much.
constexpr double kAnotherVisit_m = 20.0;

// Keyframes are 5 to 10 m apart. A step of so many usual ones is no gap, up to this length: beyond
// it the way between two poses is unknown.
constexpr double kUsualSteps = 3.0;
constexpr double kLongestUsualGap_m = 15.0;
constexpr std::size_t kFewestSteps = 10;  // have a usual one
// Where gaps take more of the way than this, a warning names them.
constexpr double kMostInGaps = 0.1;

using Run = std::vector<Pose>;  // consecutive kept poses of one piece without a gap

// A pose of the route, of whichever run.
struct RoutePose {
  Pose T_map_vehicle;
  std::uint32_t piece = 0;
  std::uint32_t part = 0;  // of the drive
  double driven_m = 0.0;   // from the first pose
};

// Without those where the vehicle stands, unless another piece begins.
std::vector<RoutePose> moving_poses(const std::vector<RoutePose>& poses) {
  std::vector<RoutePose> moving;
  for (const RoutePose& pose : poses) {
    double step_m = 0.0;
    if (!moving.empty()) {
      const RoutePose& last = moving.back();
      step_m = (pose.T_map_vehicle.translation() - last.T_map_vehicle.translation()).norm();
      const bool goes_on = pose.piece == last.piece && pose.part == last.part;
      if (goes_on && step_m < kSmallestStep_m) continue;
    }
    moving.push_back(pose);
    moving.back().driven_m = moving.size() > 1 ? moving[moving.size() - 2].driven_m + step_m : 0.0;
  }
  return moving;
}

// Lengths of the steps within pieces and parts.
std::vector<double> steps_m(const std::vector<RoutePose>& poses) {
  std::vector<double> steps_m;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const bool goes_on = poses[i].piece == poses[i - 1].piece && poses[i].part == poses[i - 1].part;
    if (goes_on) steps_m.push_back(poses[i].driven_m - poses[i - 1].driven_m);
  }
  return steps_m;
}

// The largest step within a run, by the option and by the usual step of these poses.
double largest_gap_of(const ChooseSitesOptions& options, std::vector<double> steps_m) {
  if (steps_m.size() < kFewestSteps) return options.largest_gap_m;
  std::ranges::sort(steps_m);
  const double usual_m = quantile_of_sorted(steps_m, 0.5);
  return std::max(options.largest_gap_m, std::min(kUsualSteps * usual_m, kLongestUsualGap_m));
}

void warn_of_gaps(const PassContext& ctx, const std::vector<double>& steps_m,
                  double largest_gap_m) {
  double way_m = 0.0;
  double without_m = 0.0;
  std::size_t gaps = 0;
  for (const double step_m : steps_m) {
    way_m += step_m;
    if (step_m <= largest_gap_m) continue;
    without_m += step_m;
    ++gaps;
  }
  if (without_m <= kMostInGaps * way_m) return;
  ctx.warn(concat(gaps, " steps between poses are longer than ", fixed(largest_gap_m, 1),
                  " m: ", fixed(without_m, 0), " of ", fixed(way_m, 0),
                  " m of route have no sites. Set choose-sites.largest_gap_m to a larger value to "
                  "have sites there"));
}

// Whether two poses are of one stretch of way.
bool is_step(const RoutePose& from, const RoutePose& to, double largest_gap_m) {
  return from.piece == to.piece && from.part == to.part &&
         to.driven_m - from.driven_m <= largest_gap_m;
}

// Which poses are where the vehicle was before, in the same direction.
class Revisits {
 public:
  Revisits(const std::vector<RoutePose>& poses, double largest_gap_m)
      : poses_(poses), largest_gap_m_(largest_gap_m), grid_(positions_of(poses)) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const bool was_revisit = i > 0 && is_revisit_[i - 1];
      is_revisit_.push_back(comes_back(i, was_revisit ? kLeavesWay_m : kSameWay_m));
    }
  }
  [[nodiscard]] bool operator[](std::size_t i) const { return is_revisit_[i]; }

 private:
  static constexpr double kSameWay_m = 2.0;
  static constexpr double kLeavesWay_m = 2.5;                   // so that runs do not flicker
  static constexpr double kSameDirection = 0.7071067811865476;  // cosine of 45 degrees

  static std::vector<Eigen::Vector3d> positions_of(const std::vector<RoutePose>& poses) {
    std::vector<Eigen::Vector3d> positions_m;
    for (const RoutePose& pose : poses) positions_m.push_back(pose.T_map_vehicle.translation());
    return positions_m;
  }

  [[nodiscard]] bool comes_back(std::size_t i, double reach_m) const {
    bool found = false;
    grid_.visit_within(poses_[i].T_map_vehicle.translation(),
                       reach_m + 0.5 * largest_gap_m_ + kLevelHeight_m, [&](const NearPoint& near) {
                         if (!found) found = is_passed_by(near.index, i, reach_m);
                       });
    return found;
  }

  // Whether the way from an earlier pose to the next one passes pose `i`.
  [[nodiscard]] bool is_passed_by(std::size_t earlier, std::size_t i, double reach_m) const {
    if (earlier >= i || is_revisit_[earlier]) return false;
    const RoutePose& from = poses_[earlier];
    const RoutePose& here = poses_[i];
    const RoutePose& to = earlier + 1 < i ? poses_[earlier + 1] : from;
    if (from.part == here.part && here.driven_m - to.driven_m < kAnotherVisit_m) return false;
    const Eigen::Vector3d ahead = from.T_map_vehicle.linear().col(0);
    if (ahead.dot(here.T_map_vehicle.linear().col(0)) < kSameDirection) return false;
    const Eigen::Vector3d offset_m =
        here.T_map_vehicle.translation() - from.T_map_vehicle.translation();
    Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
    if (is_step(from, to, largest_gap_m_)) {
      step_m = to.T_map_vehicle.translation() - from.T_map_vehicle.translation();
    }
    const double length2 = step_m.squaredNorm();
    const double share = length2 > 0.0 ? std::clamp(offset_m.dot(step_m) / length2, 0.0, 1.0) : 0.0;
    const Eigen::Vector3d beside_m = offset_m - share * step_m;
    return beside_m.head<2>().norm() <= reach_m && is_same_level(beside_m.z(), 0.0);
  }

  const std::vector<RoutePose>& poses_;
  double largest_gap_m_;
  PointGrid grid_;
  std::vector<bool> is_revisit_;
};

std::vector<Run> split_into_runs(const std::vector<RoutePose>& poses, double largest_gap_m) {
  const Revisits revisits(poses, largest_gap_m);
  std::vector<Run> runs;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (revisits[i]) continue;
    const bool goes_on =
        i > 0 && !revisits[i - 1] && is_step(poses[i - 1], poses[i], largest_gap_m);
    if (!goes_on) runs.emplace_back();
    runs.back().push_back(poses[i].T_map_vehicle);
  }
  return runs;
}

// Appends the sites of one run; the k-th is at k * spacing_m exactly, so that no error adds up.
void append_sites(const Run& poses, const Pose& T_vehicle_lidar, Sites& sites) {
  const std::uint32_t run = sites.sites.empty() ? 0 : sites.sites.back().run + 1;
  std::uint32_t next = 0;
  const auto place = [&](const Pose& T_map_vehicle) {
    const Pose T_map_lidar = T_map_vehicle * T_vehicle_lidar;
    const double s_m = next++ * sites.spacing_m;
    sites.sites.push_back({run, s_m, T_map_vehicle, T_map_lidar.translation()});
  };
  place(poses.front());
  double start_m = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double step_m = (poses[i].translation() - poses[i - 1].translation()).norm();
    while (next * sites.spacing_m <= start_m + step_m + kRounding_m) {
      const double fraction = (next * sites.spacing_m - start_m) / step_m;
      place(interpolate(poses[i - 1], poses[i], std::clamp(fraction, 0.0, 1.0)));
    }
    start_m += step_m;
  }
}

}  // namespace

std::vector<OptionField> option_fields(ChooseSitesOptions& options) {
  return {
      number("spacing_m", options.spacing_m, "distance between sites along the route, m", 0.1,
             100.0),
      number(
          "largest_gap_m", options.largest_gap_m,
          "largest step between poses within a run of sites, m; three times the usual step, up to "
          "15 m, if that is more",
          0.1, 1000.0),
      scans_option(options.scans),
  };
}

Result<Sites> choose_sites(PassContext& ctx, const ChooseSitesOptions& options, const Drive& drive,
                           const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  std::vector<RoutePose> poses;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const TrajectoryPose& pose = trajectory.poses[i];
    if (!is_selected(drive.scans[i], options.scans) || !pose.is_laid) continue;
    poses.push_back({pose.T_map_vehicle, pose.piece, drive.scans[i].part});
  }
  if (poses.empty()) {
    return Error{ErrorCode::kDriveTooShort,
                 concat("none of the drive's ", drive.scans.size(), " scans is ",
                        (options.scans == ScanSelection::kAll ? "there" : name_of(options.scans)),
                        ", expected at least one"),
                 "", "pass choose-sites"};
  }
  Sites sites;
  sites.frame = trajectory.frame;
  sites.spacing_m = options.spacing_m;
  const std::vector<RoutePose> moving = moving_poses(poses);
  const std::vector<double> steps_of_way_m = steps_m(moving);
  const double largest_gap_m = largest_gap_of(options, steps_of_way_m);
  warn_of_gaps(ctx, steps_of_way_m, largest_gap_m);
  for (const Run& run : split_into_runs(moving, largest_gap_m)) {
    append_sites(run, drive.sensor.T_vehicle_lidar, sites);
  }
  ctx.progress(poses.size(), poses.size());
  return sites;
}

}  // namespace sightline
