// How far an estimated trajectory is from the truth: drives through generated towns, their poses
// thrown away or disturbed. Prints one row a drive; errors after the best rigid fit.

#include <CLI/CLI.hpp>
#include <Eigen/SVD>
#include <chrono>
#include <cstdio>

#include "examples/town/drive/drive.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "tests/bench/bench_tools.h"

namespace {

using namespace sightline;

struct BenchOptions {
  std::vector<std::uint64_t> seeds = {1};
  double length_m = 600.0;
  double spacing_m = 1.0;
  double overlap_m = 30.0;
  int beams = 16;
  bool is_straight = false;
  std::vector<std::string> poses = {"none"};
  std::string dump;
  EstimateTrajectoryOptions estimate;
};

// Three waves of unit deviation together, as positioning drifts.
double slow_wave(Random& random, std::vector<double>& phases, std::size_t axis, double s_m) {
  constexpr double kWavelengths_m[3] = {60.0, 150.0, 310.0};
  while (phases.size() < 3 * (axis + 1)) phases.push_back(random.uniform(0.0, 6.283));
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    sum += std::sin(6.283 * s_m / kWavelengths_m[i] + phases[3 * axis + i]);
  }
  return sum * std::sqrt(2.0 / 3.0);
}

// Off by 0.5 m and 0.5 degrees: root mean square over the drive of the whole deviation.
std::vector<Pose> disturbed(const std::vector<Pose>& truth, double spacing_m, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> phases;
  std::vector<Pose> poses = truth;
  const double share = 0.5 / std::sqrt(3.0);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double s_m = spacing_m * static_cast<double>(i);
    Eigen::Vector3d shift_m;
    Eigen::Vector3d turn_deg;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      shift_m[static_cast<Eigen::Index>(axis)] = share * slow_wave(random, phases, axis, s_m);
      turn_deg[static_cast<Eigen::Index>(axis)] = share * slow_wave(random, phases, axis + 3, s_m);
    }
    poses[i].translation() += shift_m;
    const double angle_rad = turn_deg.norm() * std::numbers::pi / 180.0;
    poses[i].linear() *= Eigen::AngleAxisd(angle_rad, turn_deg.normalized()).toRotationMatrix();
  }
  return poses;
}

struct TrajectoryError {
  double rmse_m = 0.0;
  double rmse_z_m = 0.0;
  double largest_m = 0.0;
  double end_to_end_m = 0.0;  // the last pose as the first one sees it
  double heading_rms_deg = 0.0;
};

TrajectoryError error_of(const std::vector<Pose>& found, const std::vector<Pose>& truth) {
  Eigen::Matrix3Xd a(3, truth.size());
  Eigen::Matrix3Xd b(3, truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    a.col(static_cast<Eigen::Index>(i)) = found[i].translation();
    b.col(static_cast<Eigen::Index>(i)) = truth[i].translation();
  }
  Pose T_truth_found;
  T_truth_found.matrix() = Eigen::umeyama(a, b, false);
  TrajectoryError error;
  const auto count = static_cast<double>(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Pose laid = T_truth_found * found[i];
    const Eigen::Vector3d off_m = laid.translation() - truth[i].translation();
    error.rmse_m += off_m.squaredNorm() / count;
    error.rmse_z_m += off_m.z() * off_m.z() / count;
    error.largest_m = std::max(error.largest_m, off_m.norm());
  }
  error.rmse_m = std::sqrt(error.rmse_m);
  error.rmse_z_m = std::sqrt(error.rmse_z_m);
  const Pose by_found = found.front().inverse() * found.back();
  const Pose by_truth = truth.front().inverse() * truth.back();
  error.end_to_end_m = (by_found.translation() - by_truth.translation()).norm();
  return error;
}

int run_one(const BenchOptions& options, std::uint64_t seed) {
  const Result<town::Town> made = town::make_town({seed, options.length_m, !options.is_straight});
  const Result<SensorProfile> sensor = town::town_sensor(options.beams);
  if (!made || !sensor) return 1;
  town::DriveOptions drive_options = town::usual_drive(made->options, 0, *sensor);
  drive_options.length_m = options.length_m + (options.is_straight ? 0.0 : options.overlap_m);
  drive_options.spacing_m = options.spacing_m;
  const Result<town::DriveSimulator> simulator = town::DriveSimulator::make(*made, drive_options);
  if (!simulator) return 1;
  const std::vector<Pose>& truth = simulator->T_town_vehicle();
  Drive drive = town::recorded(*simulator, "town", truth, 2);
  for (const std::string& kind : options.poses) {
    const std::vector<Pose> given = disturbed(truth, options.spacing_m, seed);
    EstimateTrajectoryOptions estimate = options.estimate;
    estimate.mode = kind == "none" ? PoseMode::kEstimate : PoseMode::kRefine;
    for (std::size_t i = 0; i < drive.scans.size(); ++i) {
      drive.scans[i].T_world_vehicle = std::nullopt;
      if (kind != "none") drive.scans[i].T_world_vehicle = given[i];
    }
    PassContext ctx;
    ctx.threads = 2;
    ctx.warning_sink = [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
    const double before_s = cpu_s();
    const auto from = std::chrono::steady_clock::now();
    const Result<Trajectory> trajectory = estimate_trajectory(ctx, estimate, drive);
    const double took_s = cpu_s() - before_s;
    const double wall_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    if (!trajectory) {
      std::printf("%4d %s %s\n", static_cast<int>(seed), kind.c_str(),
                  to_string(trajectory.error()).c_str());
      continue;
    }
    std::vector<Pose> found;
    for (const TrajectoryPose& pose : trajectory->poses) found.push_back(pose.T_map_vehicle);
    const TrajectoryError error = error_of(found, truth);
    const double way_m = drive_options.length_m;
    std::printf(
        "%4d %-9s %6.0f m %5zu scans | rmse %6.3f (z %6.3f) max %6.3f | end %6.3f m %6.3f %% |"
        " loops %3u | cpu %5.1f s wall %5.1f s = %4.2f x real time\n",
        static_cast<int>(seed), kind.c_str(), way_m, truth.size(), error.rmse_m, error.rmse_z_m,
        error.largest_m, error.end_to_end_m, 100.0 * error.end_to_end_m / way_m,
        trajectory->loop_edges, took_s, wall_s, 0.1 * static_cast<double>(truth.size()) / wall_s);
    std::fflush(stdout);
    if (!options.dump.empty()) {
      std::FILE* file = std::fopen(options.dump.c_str(), "w");
      for (std::size_t i = 0; i < truth.size(); ++i) {
        const Eigen::Vector3d a = found[i].translation();
        const Eigen::Vector3d b = truth[i].translation();
        const Eigen::AngleAxisd r(truth[0].linear() * found[0].linear().transpose() *
                                  found[i].linear() * truth[i].linear().transpose());
        const Eigen::Vector3d w = 57.29578 * r.angle() * r.axis();
        std::fprintf(file, "%f %f %f %f %f %f %f %f %f\n", a.x(), a.y(), a.z(), b.x(), b.y(), b.z(),
                     w.x(), w.y(), w.z());
      }
      std::fclose(file);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  BenchOptions options;
  CLI::App app(
      "Drives through towns, estimates where they went, and measures how far off that is.");
  app.add_option("--seeds", options.seeds);
  app.add_option("--length-m", options.length_m);
  app.add_option("--spacing-m", options.spacing_m);
  app.add_option("--overlap-m", options.overlap_m);
  app.add_option("--beams", options.beams);
  app.add_flag("--straight", options.is_straight);
  app.add_option("--poses", options.poses);
  app.add_option("--dump", options.dump);
  app.add_flag("!--no-loops", options.estimate.closes_loops);
  CLI11_PARSE(app, argc, argv);
  for (const std::uint64_t seed : options.seeds)
    if (run_one(options, seed) != 0) return 1;
  return 0;
}
