// What a recording without true poses says of its estimated trajectory: how far odd scans, matched
// against the map of the even ones, end from it, and how sharp the map is with estimated and with
// given poses.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "formats/foreign/recording/open_recording.h"
#include "passes/ingest/ingest.h"
#include "passes/map/build_ndt.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/matching/matcher.h"
#include "passes/matching/scan_preparation.h"
#include "passes/trajectory/estimate_trajectory.h"

namespace {

using namespace sightline;

double at_share(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

std::vector<Eigen::Vector3d> in_range_m(const Drive& drive, std::size_t scan) {
  return crop(drive.store->read(scan)->points_m, std::min(100.0, drive.sensor.max_range_m));
}

std::vector<double> odd_against_even_m(const Drive& drive, const Trajectory& trajectory) {
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t k = 0; k < drive.scans.size(); k += 2) {
    const Pose T_map_lidar = trajectory.poses[k].T_map_vehicle * drive.sensor.T_vehicle_lidar;
    for (const Eigen::Vector3d& point_m : in_range_m(drive, k)) {
      points_m.push_back(T_map_lidar * point_m);
    }
  }
  const MatchGrid grid = make_match_grid(ndt_from_points(points_m, trajectory.frame, {}, 2));
  std::vector<double> off_m;
  for (std::size_t k = 1; k < drive.scans.size(); k += 2) {
    const Pose T_map_lidar = trajectory.poses[k].T_map_vehicle * drive.sensor.T_vehicle_lidar;
    const MatchResult found = match(grid, voxel_subsample(in_range_m(drive, k), 1.0), T_map_lidar);
    off_m.push_back((found.T_map_sensor.translation() - T_map_lidar.translation()).norm());
  }
  return off_m;
}

void print(const char* poses, const Drive& drive, const Trajectory& trajectory,
           const SharpnessFigures& sharpness) {
  const std::vector<double> off_m = odd_against_even_m(drive, trajectory);
  std::printf(
      "%-10s | odd against even: median %.3f m, p90 %.3f m | entropy %.4f nat, plane "
      "variance %.3f cm2\n",
      poses, at_share(off_m, 0.5), at_share(off_m, 0.9), sharpness.mean_entropy_nat,
      1e4 * sharpness.mean_plane_variance_m2);
}

int report(const Error& error) {
  std::fprintf(stderr, "%s\n", to_string(error).c_str());
  return 1;
}

int run(const RecordingOptions& options) {
  const Result<Recording> recording = open_recording(options, 2);
  if (!recording) return report(recording.error());
  PassContext ctx;
  ctx.threads = 2;
  ctx.warning_sink = [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
  const Result<Drive> drive = ingest(ctx, {}, *recording);
  if (!drive) return report(drive.error());
  EstimateTrajectoryOptions estimate;
  estimate.mode = PoseMode::kEstimate;
  const auto from = std::chrono::steady_clock::now();
  const Result<Trajectory> found = estimate_trajectory(ctx, estimate, *drive);
  if (!found) return report(found.error());
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
  const Result<Sharpness> sharpness = measure_sharpness(ctx, {}, *drive, *found);
  if (!sharpness) return report(sharpness.error());
  std::printf("%zu scans, estimated in %.1f s\n", drive->scans.size(), wall_s);
  print("estimated", *drive, *found, sharpness->of_map);
  if (!drive->has_poses()) return 0;
  estimate.mode = PoseMode::kGiven;
  const Result<Trajectory> given = estimate_trajectory(ctx, estimate, *drive);
  if (!given) return report(given.error());
  const Result<Sharpness> with_given = measure_sharpness(ctx, {}, *drive, *given);
  if (!with_given) return report(with_given.error());
  print("given", *drive, *given, with_given->of_map);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  RecordingOptions options;
  options.poses_of = PosesOf::kSensor;
  CLI::App app("Estimates where a recorded drive went and judges that by the scans alone.");
  app.add_option("--scans", options.scans)->required();
  app.add_option("--poses", options.poses);
  app.add_option("--sensor", options.sensor);
  CLI11_PARSE(app, argc, argv);
  return run(options);
}
