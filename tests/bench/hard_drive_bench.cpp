// What estimate-trajectory says of drives through worlds that are hard to map, without poses,
// beside what the scans constrain in truth (constraint.h). One row a drive:
//   way       the estimated way's length, off by so much
//   end       error of the last position relative to the first, and its standard deviations
//   20, 100 m error of relative positions over so much of the way without an unconstrained pose,
//             ahead and to the left in the vehicle's axes, root mean square and largest, cm
//   missed    of directions that nothing constrains in truth for 20 m and more: m not named
//   wrongly   of metres that are constrained in a direction: named in it, worst kind of place

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "examples/town/drive/constraint.h"
#include "examples/town/drive/drive.h"
#include "formats/base/parallel.h"
#include "formats/drive/unconstrained_stretches.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "tests/bench/bench_tools.h"

namespace {

using namespace sightline;

struct BenchOptions {
  std::vector<std::string> worlds = {"tunnel"};
  std::vector<std::uint64_t> seeds = {1, 2, 3};
  double length_m = 0.0;
  int beams = 16;
  double every_m = 5.0;
  int threads = 1;
  std::string scans;  // file for one line a scan
};

// A drive, and what is true of each scan.
struct TrueDrive {
  Drive drive;
  std::vector<Pose> T_town_vehicle;
  std::vector<double> driven_m;
  std::vector<std::string> kinds;
  std::vector<town::Constraint> constraints;  // of the nearest scan that was examined
};

std::vector<town::Constraint> constraints_of(const town::DriveSimulator& simulator,
                                             const BenchOptions& options) {
  std::vector<std::size_t> examined;
  for (std::size_t i = 0; i < simulator.scan_count(); ++i) {
    const double next_m = static_cast<double>(examined.size()) * options.every_m;
    if (simulator.driven_m(i) - simulator.driven_m(0) >= next_m) examined.push_back(i);
  }
  const std::vector<town::Constraint> found = parallel_map<town::Constraint>(
      examined.size(), options.threads,
      [&](std::size_t i) { return town::constraint_of(simulator, examined[i]); });
  std::vector<town::Constraint> all;
  for (std::size_t i = 0, at = 0; i < simulator.scan_count(); ++i) {
    const auto away_m = [&](std::size_t n) {
      return std::abs(simulator.driven_m(examined[n]) - simulator.driven_m(i));
    };
    if (at + 1 < examined.size() && away_m(at + 1) < away_m(at)) ++at;
    all.push_back(found[at]);
  }
  return all;
}

Result<TrueDrive> true_drive(const BenchOptions& options, const std::string& world,
                             std::uint64_t seed) {
  town::TownOptions made;
  made.seed = seed;
  made.world = town::world_kind(world).value_or(town::WorldKind());
  made.length_m = options.length_m > 0.0 ? options.length_m : town::usual_length_m(made.world);
  SIGHTLINE_ASSIGN(const town::Town town, town::make_town(made));
  SIGHTLINE_ASSIGN(const SensorProfile sensor, town::town_sensor(options.beams));
  SIGHTLINE_ASSIGN(const town::DriveSimulator simulator,
                   town::DriveSimulator::make(town, town::usual_drive(made, 0, sensor)));
  TrueDrive one;
  one.T_town_vehicle = simulator.T_town_vehicle();
  one.drive = town::recorded(simulator, world, one.T_town_vehicle, options.threads);
  for (ScanInfo& scan : one.drive.scans) scan.T_world_vehicle.reset();
  for (std::size_t i = 0; i < simulator.scan_count(); ++i) {
    one.driven_m.push_back(simulator.driven_m(i));
    one.kinds.emplace_back(
        town.is_hard()
            ? town::place_kind_name(town::place_at(town.places, simulator.driven_m(i)).kind)
            : "streets");
  }
  one.constraints = town.is_hard() ? constraints_of(simulator, options)
                                   : std::vector<town::Constraint>(simulator.scan_count());
  return one;
}

Eigen::Vector3d relative_m(const Pose& from, const Pose& to) {
  return from.linear().transpose() * (to.translation() - from.translation());
}

// How far the relative position of two poses is off, in the axes of the first.
Eigen::Vector3d off_m(const TrueDrive& truth, const Trajectory& found, std::size_t from,
                      std::size_t to) {
  return relative_m(found.poses[from].T_map_vehicle, found.poses[to].T_map_vehicle) -
         relative_m(truth.T_town_vehicle[from], truth.T_town_vehicle[to]);
}

// Errors of relative positions over a length of way on which no pose is named.
struct WindowErrors {
  double squares[2] = {0.0, 0.0};
  double largest_m[2] = {0.0, 0.0};
  std::size_t count = 0;

  void print() const {
    if (count == 0) return (void)std::printf(" |                    -   ");
    const auto rms_cm = [&](int i) {
      return 100.0 * std::sqrt(squares[i] / static_cast<double>(count));
    };
    std::printf(" | %5.1f %5.1f (%5.1f %5.1f)", rms_cm(0), rms_cm(1), 100.0 * largest_m[0],
                100.0 * largest_m[1]);
  }
};

WindowErrors window_errors(const TrueDrive& truth, const Trajectory& found, double length_m) {
  WindowErrors errors;
  const std::size_t count = truth.driven_m.size();
  for (std::size_t begin = 0; begin + 1 < count; ++begin) {
    std::size_t end = begin;
    bool is_named = false;
    while (end + 1 < count && truth.driven_m[end] - truth.driven_m[begin] < length_m) {
      ++end;
      is_named = is_named || found.poses[end].unconstrained.is_any() ||
                 found.poses[end].piece != found.poses[begin].piece;
    }
    if (is_named || truth.driven_m[end] - truth.driven_m[begin] < length_m) continue;
    const Eigen::Vector3d off = off_m(truth, found, begin, end);
    ++errors.count;
    for (int i = 0; i < 2; ++i) {
      errors.squares[i] += off[i] * off[i];
      errors.largest_m[i] = std::max(errors.largest_m[i], std::abs(off[i]));
    }
  }
  return errors;
}

// Which poses are named in a direction, and where it is not constrained in truth.
struct Naming {
  std::vector<bool> is_named;
  std::vector<bool> is_unconstrained;
};

Naming naming(const TrueDrive& truth, const Trajectory& found, bool is_ahead) {
  Naming of;
  for (std::size_t i = 0; i < found.poses.size(); ++i) {
    const Unconstrained& named = found.poses[i].unconstrained;
    const town::Constraint& constraint = truth.constraints[i];
    of.is_named.push_back(is_ahead ? named.along : named.across);
    of.is_unconstrained.push_back((is_ahead ? constraint.kept_ahead : constraint.kept_left) > 0.5);
  }
  return of;
}

double step_m(const TrueDrive& truth, std::size_t i) {
  return i == 0 ? 0.0 : truth.driven_m[i] - truth.driven_m[i - 1];
}

struct Missed {
  double way_m = 0.0;  // of stretches of 20 m and more
  double missed_m = 0.0;
};

void add_missed(const TrueDrive& truth, const Naming& of, Missed& missed) {
  constexpr double kLeastWay_m = 20.0;
  for (std::size_t begin = 0; begin < of.is_unconstrained.size();) {
    if (!of.is_unconstrained[begin]) {
      ++begin;
      continue;
    }
    double way_m = 0.0;
    double missed_m = 0.0;
    std::size_t end = begin;
    for (; end < of.is_unconstrained.size() && of.is_unconstrained[end]; ++end) {
      way_m += step_m(truth, end);
      missed_m += of.is_named[end] ? 0.0 : step_m(truth, end);
    }
    begin = end;
    if (way_m < kLeastWay_m) continue;
    missed.way_m += way_m;
    missed.missed_m += missed_m;
  }
}

struct Wrongly {
  double constrained_m = 0.0;
  double named_m = 0.0;
};

void add_wrongly(const TrueDrive& truth, const Naming& of, std::map<std::string, Wrongly>& kinds) {
  for (std::size_t i = 1; i < of.is_named.size(); ++i) {
    if (of.is_unconstrained[i]) continue;
    Wrongly& kind = kinds[truth.kinds[i]];
    kind.constrained_m += step_m(truth, i);
    kind.named_m += of.is_named[i] ? step_m(truth, i) : 0.0;
  }
}

void write_scans(std::FILE* file, const TrueDrive& truth, const Trajectory& found) {
  for (std::size_t i = 1; i < found.poses.size(); ++i) {
    const Eigen::Vector3d off = off_m(truth, found, i - 1, i);
    const Unconstrained& named = found.poses[i].unconstrained;
    std::fprintf(file, "%s %zu %.2f %s %.3f %.3f %d%d%d %.4f %.4f\n", truth.drive.name.c_str(), i,
                 truth.driven_m[i], truth.kinds[i].c_str(), truth.constraints[i].kept_ahead,
                 truth.constraints[i].kept_left, int{named.along}, int{named.across},
                 int{named.heading}, off.x(), off.y());
  }
}

void print_named(const TrueDrive& truth, const Trajectory& found) {
  Missed missed;
  std::printf(" |");
  std::map<std::string, Wrongly> kinds;
  for (const bool is_ahead : {true, false}) {
    const Naming of = naming(truth, found, is_ahead);
    add_missed(truth, of, missed);
    std::map<std::string, Wrongly> of_direction;
    add_wrongly(truth, of, of_direction);
    for (const auto& [kind, wrongly] : of_direction) {
      Wrongly& worst = kinds[kind];
      if (wrongly.named_m * worst.constrained_m >= worst.named_m * wrongly.constrained_m) {
        worst = wrongly;
      }
    }
  }
  std::printf(" %5.0f of %5.0f m |", missed.missed_m, missed.way_m);
  for (const auto& [kind, wrongly] : kinds) {
    std::printf(" %s %.0f %%", kind.c_str(),
                100.0 * wrongly.named_m / std::max(1e-9, wrongly.constrained_m));
  }
}

double way_m(const std::vector<Pose>& poses) {
  double sum_m = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    sum_m += (poses[i].translation() - poses[i - 1].translation()).norm();
  }
  return sum_m;
}

void print_end(const TrueDrive& truth, const Trajectory& found) {
  std::vector<Pose> poses;
  for (const TrajectoryPose& pose : found.poses) poses.push_back(pose.T_map_vehicle);
  const double longer = way_m(poses) / way_m(truth.T_town_vehicle) - 1.0;
  const Eigen::Vector3d end_m = off_m(truth, found, 0, poses.size() - 1);
  const Eigen::Vector3d in_map_m = poses.front().linear() * end_m;
  const Eigen::Matrix2d covariance = found.poses.back().covariance.matrix().topLeftCorner<2, 2>();
  const Eigen::Vector2d weighted = covariance.inverse() * in_map_m.head<2>();
  std::printf("%u pieces | way %+6.2f %% | end %6.2f m %5.1f sigma", found.poses.back().piece + 1,
              100.0 * longer, end_m.head<2>().norm(), std::sqrt(in_map_m.head<2>().dot(weighted)));
}

void print_stretches(const TrueDrive& truth, const Trajectory& found) {
  for (const UnconstrainedStretch& stretch : unconstrained_stretches(found)) {
    const std::size_t from = stretch.first_scan == 0 ? 0 : stretch.first_scan - 1;
    const std::size_t to = stretch.last_scan;
    const Eigen::Vector3d off = off_m(truth, found, from, to);
    std::printf("    %.0f to %.0f m: %s; off by %+.2f %+.2f m, sigma %.2f m\n",
                truth.driven_m[from], truth.driven_m[to],
                directions_text(stretch.directions).c_str(), off.x(), off.y(),
                stretch.sigma_m.value_or(-1.0));
  }
}

Result<void> run_one(const BenchOptions& options, const std::string& world, std::uint64_t seed,
                     std::FILE* scans) {
  SIGHTLINE_ASSIGN(const TrueDrive truth, true_drive(options, world, seed));
  EstimateTrajectoryOptions estimate;
  estimate.mode = PoseMode::kEstimate;
  PassContext ctx;
  ctx.threads = options.threads;
  ctx.warning_sink = [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
  const double before_s = cpu_s();
  SIGHTLINE_ASSIGN(const Trajectory found, estimate_trajectory(ctx, estimate, truth.drive));
  const double took_s = cpu_s() - before_s;
  std::printf("%-13s %llu %4zu scans ", world.c_str(), static_cast<unsigned long long>(seed),
              found.poses.size());
  print_end(truth, found);
  window_errors(truth, found, 20.0).print();
  window_errors(truth, found, 100.0).print();
  print_named(truth, found);
  std::printf(" | cpu %.1f s\n", took_s);
  print_stretches(truth, found);
  std::fflush(stdout);
  if (scans != nullptr) write_scans(scans, truth, found);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  BenchOptions options;
  CLI::App app("Estimates drives through hard worlds, and compares what is named with the truth.");
  app.add_option("--worlds", options.worlds);
  app.add_option("--seeds", options.seeds);
  app.add_option("--length-m", options.length_m);
  app.add_option("--beams", options.beams);
  app.add_option("--constraints-m", options.every_m);
  app.add_option("--threads", options.threads);
  app.add_option("--scans", options.scans);
  CLI11_PARSE(app, argc, argv);
  std::FILE* scans = options.scans.empty() ? nullptr : std::fopen(options.scans.c_str(), "w");
  for (const std::string& world : options.worlds) {
    for (const std::uint64_t seed : options.seeds) {
      const Result<void> ran = run_one(options, world, seed, scans);
      if (!ran) std::printf("%s %s\n", world.c_str(), to_string(ran.error()).c_str());
    }
  }
  if (scans != nullptr) std::fclose(scans);
  return 0;
}
