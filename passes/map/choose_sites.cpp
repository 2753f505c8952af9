#include "passes/map/choose_sites.h"

#include <algorithm>
#include <cmath>

#include "formats/drive/trajectory_of_drive.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
namespace {

// Standing at a light adds noise, not route.
constexpr double kSmallestStep_m = 0.1;
// A site that rounding puts this far behind a run's end still belongs to it: 100 steps of 0.1 m are
// to make 10 m.
constexpr double kRounding_m = 1e-9;

using Run = std::vector<Pose>;  // consecutive kept poses of one piece without a gap

std::vector<Run> split_into_runs(const std::vector<const TrajectoryPose*>& poses,
                                 double largest_gap_m) {
  std::vector<Run> runs;
  std::uint32_t piece = 0;
  for (const TrajectoryPose* at : poses) {
    const Pose& pose = at->T_map_vehicle;
    if (!runs.empty() && at->piece == piece) {
      const double step_m = (pose.translation() - runs.back().back().translation()).norm();
      if (step_m < kSmallestStep_m) continue;
      if (step_m <= largest_gap_m) {
        runs.back().push_back(pose);
        continue;
      }
    }
    runs.push_back({pose});
    piece = at->piece;
  }
  return runs;
}

// Appends the sites of one run; the k-th lies at k * spacing_m exactly, so that no error adds up.
void append_sites(const Run& poses, const Pose& T_vehicle_lidar, Sites& sites) {
  const std::uint32_t run = sites.sites.empty() ? 0 : sites.sites.back().run + 1;
  std::uint32_t next = 0;
  const auto place = [&](const Pose& T_map_vehicle) {
    const Pose T_map_lidar = T_map_vehicle * T_vehicle_lidar;
    sites.sites.push_back({run, next * sites.spacing_m, T_map_vehicle, T_map_lidar.translation()});
    ++next;
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
      number("spacing_m", options.spacing_m, "arc length between sites, m", 0.1, 100.0),
      number("largest_gap_m", options.largest_gap_m,
             "a longer step between poses starts a new run of sites, m", 0.1, 1000.0),
      scans_option(options.scans),
  };
}

Result<Sites> choose_sites(PassContext& ctx, const ChooseSitesOptions& options, const Drive& drive,
                           const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  const ScanSelection selection = options.scans;
  std::vector<const TrajectoryPose*> poses;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (is_selected(drive.scans[i], selection)) poses.push_back(&trajectory.poses[i]);
  }
  if (poses.empty()) {
    return Error{
        ErrorCode::kDriveTooShort,
        "none of the drive's " + std::to_string(drive.scans.size()) + " scans is " +
            (selection == ScanSelection::kAll ? "there"
                                              : std::string(scan_selection_name(selection))) +
            ", expected at least one",
        "", "pass choose-sites"};
  }
  Sites sites;
  sites.frame = trajectory.frame;
  sites.spacing_m = options.spacing_m;
  for (const Run& run : split_into_runs(poses, options.largest_gap_m)) {
    append_sites(run, drive.sensor.T_vehicle_lidar, sites);
  }
  ctx.progress(poses.size(), poses.size());
  return sites;
}

}  // namespace sightline
