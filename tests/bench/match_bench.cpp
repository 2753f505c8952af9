#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "examples/town/drive/drive.h"
#include "formats/base/random.h"
#include "formats/base/stopwatch.h"
#include "formats/evaluation/look_evaluation.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/scan_preparation.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/pcl_peers.h"
#include "tests/bench/posed_set.h"

// One match beside PCL's NDT, in turn and in one process: the same points, cells and starts, one
// thread. On the set kitti_0005 of tests/README.md where it is there (with its poses in
// SIGHTLINE_KITTI_POSES: 12 numbers a row), else in a generated town. Each scan is matched from one
// start 0.5 to 1 m and 2 degrees off. Prints, for each cell size and range, medians of CPU time and
// error, how many runs ended more than 0.5 m off ("lost"), and how many times faster than PCL.
//
//   plain     the map's cells, as defined for measured error
//   annealed  blurred, then sharpened NDs of the same cells
//   searching annealed, looking along a loose direction (the default)
//   refined   the same, then sharpened NDs of 0.5 m cells
//
// Below them whole localizations by looks: cut, preparation and match of a scan whose returns are
// no longer in the caches, beside PCL's match alone at 50 m, whose scan was cut for it before. The
// last line is the least time at which looks cover as much as that does ("equal coverage" within
// 10 cm and 25 cm).

namespace sightline {
namespace {

struct MatchWorld {
  std::string name;
  double leaf_m = 0.5;
  std::vector<Eigen::Vector3d> map_points_m;
  std::vector<std::vector<Eigen::Vector3d>> scans;
  std::vector<Pose> T_map_scan;
};

std::vector<Pose> read_pose_rows(const std::string& path) {
  std::vector<Pose> poses;
  std::ifstream file(path);
  for (;;) {
    Pose pose = Pose::Identity();
    for (int i = 0; i < 12; ++i) file >> pose.matrix()(i / 4, i % 4);
    if (!file) return poses;
    pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
    poses.push_back(pose);
  }
}

// Even scans make the map, odd ones are matched.
MatchWorld kitti_world(const std::string& folder, const std::vector<Pose>& poses) {
  MatchWorld world;
  world.name = "kitti_0005";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "/%010zu.pcd", i);
    const std::vector<Eigen::Vector3d> points_m = read_pcd_with_pcl(folder + name);
    if (i % 2 == 1) {
      world.scans.push_back(points_m);
      world.T_map_scan.push_back(poses[i]);
      continue;
    }
    for (const Eigen::Vector3d& point_m : points_m)
      world.map_points_m.push_back(poses[i] * point_m);
  }
  return world;
}

void add_drive(const town::Town& town, const town::DriveOptions& options, bool is_map,
               MatchWorld& world) {
  const Result<town::DriveSimulator> drive = town::DriveSimulator::make(town, options);
  for (std::size_t i = 0; i < drive->scan_count(); ++i) {
    const town::TownScan scan = drive->scan(i);
    const Pose T_map_lidar = scan.T_town_vehicle * options.sensor.T_vehicle_lidar;
    std::vector<Eigen::Vector3d> points_m;
    for (const town::LabelledPoint& point : scan.points) {
      if (!is_map || !is_moving(point.label)) points_m.push_back(point.position_m.cast<double>());
    }
    if (!is_map) {
      world.scans.push_back(points_m);
      world.T_map_scan.push_back(T_map_lidar);
      continue;
    }
    for (const Eigen::Vector3d& point_m : points_m) {
      world.map_points_m.push_back(T_map_lidar * point_m);
    }
  }
}

MatchWorld town_world() {
  MatchWorld world;
  world.name = "generated town";
  world.leaf_m = 1.0;
  const town::Town town = *town::make_town({.seed = 3, .length_m = 200.0});
  add_drive(town, town::usual_drive(town.options, 0, *town::town_sensor(16)), true, world);
  town::DriveOptions second = town::usual_drive(town.options, 1, *town::town_sensor(16));
  second.spacing_m = 3.0;
  add_drive(town, second, false, world);
  return world;
}

// The set kitti_0005 of tests/README.md where it is there with its poses, else a generated town.
// Even scans of the first make the map; of the second one drive maps and another is matched.
MatchWorld make_match_world() {
  const std::optional<PosedSet> kitti = posed_kitti_0005();
  return kitti ? kitti_world(kitti->folder, read_pose_rows(kitti->pose_file)) : town_world();
}

constexpr double kFinest_m = 0.5;

Pose start_of(const MatchWorld& world, std::size_t scan) {
  Random random(mix(7, scan));
  const double angle_rad = random.uniform(0.0, 6.28);
  const double radius_m = random.uniform(0.5, 1.0);
  Pose offset = Pose::Identity();
  offset.translation() = Eigen::Vector3d(radius_m * std::cos(angle_rad),
                                         radius_m * std::sin(angle_rad), random.uniform(-0.1, 0.1));
  const double yaw_rad = scan % 2 == 0 ? 0.035 : -0.035;
  offset.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return world.T_map_scan[scan] * offset;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

struct Runs {
  std::vector<double> times_ms, errors_m, per_point_ns;
  double iterations = 0.0;
  double evaluations = 0.0;  // of the whole scan: work over points

  void add(double time_ms, const Eigen::Vector3d& found_m, const Pose& T_map_truth) {
    times_ms.push_back(time_ms);
    errors_m.push_back((found_m - T_map_truth.translation()).norm());
  }
  [[nodiscard]] long lost() const {
    return std::count_if(errors_m.begin(), errors_m.end(), [](double e) { return e > 0.5; });
  }
  [[nodiscard]] double within(double limit_m) const {
    return static_cast<double>(std::ranges::count_if(
               errors_m, [&](double error_m) { return error_m <= limit_m; })) /
           static_cast<double>(errors_m.size());
  }
};

struct Method {
  const char* name;
  Localizer localizer;
};

void run_ours(const Method& method, const std::vector<Eigen::Vector3d>& points_m, const Pose& start,
              const Pose& truth, Runs& runs) {
  ScanForMatch scan = make_scan_for_match(method.localizer, points_m);
  const double begin_ms = thread_cpu_ms();
  const MatchResult result = localize(method.localizer, scan, start);
  runs.add(thread_cpu_ms() - begin_ms, result.T_map_sensor.translation(), truth);
  const auto points = static_cast<double>(points_m.size());
  runs.iterations += result.iterations;
  runs.evaluations += static_cast<double>(result.work) / points;
  // As a match pays it: several poses in turn, each a little way from the last.
  constexpr int kPoses = 8;
  const double again_ms = thread_cpu_ms();
  for (int i = 0; i < kPoses; ++i) {
    const Vector6d motion = 0.01 * i * Vector6d::Unit(i % 3);
    kernel_score(*method.localizer.levels.back().grid, scan, moved(truth, motion),
                 MatchKernel::kFastest);
  }
  runs.per_point_ns.push_back(1e6 * (thread_cpu_ms() - again_ms) / kPoses / points);
}

void run_pcl(PclNdt& pcl, const std::vector<Eigen::Vector3d>& points_m, const Pose& start,
             const Pose& truth, Runs& runs) {
  pcl.set_scan(points_m);
  double begin_ms = thread_cpu_ms();
  const Eigen::Matrix4d found = pcl.match(start.matrix());
  runs.add(thread_cpu_ms() - begin_ms, found.block<3, 1>(0, 3), truth);
  begin_ms = thread_cpu_ms();
  pcl.evaluate(truth.matrix());
  runs.per_point_ns.push_back(1e6 * (thread_cpu_ms() - begin_ms) /
                              static_cast<double>(points_m.size()));
}

void print_row(const char* name, double cell_m, double range_m, const Runs& runs,
               const Runs& peers) {
  const double ms = median(runs.times_ms);
  const double ns = median(runs.per_point_ns);
  const auto count = static_cast<double>(runs.times_ms.size());
  std::printf("%4g m %4g m  %-9s %8.3f ms %7.1f x  %6.2f cm %3ld lost  %7.1f ns %6.1f x", cell_m,
              range_m, name, ms, median(peers.times_ms) / ms, 100.0 * median(runs.errors_m),
              runs.lost(), ns, median(peers.per_point_ns) / ns);
  if (runs.iterations > 0.0) {
    std::printf("  %5.1f / %4.1f", runs.iterations / count, runs.evaluations / count);
  }
  std::printf("\n");
  std::fflush(stdout);
}

constexpr const char* kLooks[] = {
    "100 m, 1300 returns, evenly spaced beyond 30 m, 64 points by normals",
    "100 m, 2850 returns, evenly spaced beyond 50 m, 128 points by normals",
    "100 m, 4000 returns, evenly spaced beyond 50 m, 256 points by normals",
    "100 m, 2850 returns, evenly spaced beyond 50 m, 100 points",
    "100 m, 4000 returns, evenly spaced beyond 50 m, 256 points"};

Runs run_look(const MatchWorld& world, const Localizer& localizer, const Look& look) {
  Runs runs;
  LookCutter cutter;
  ScanForMatch cut;
  Scan scan;
  for (std::size_t i = 0; i < world.scans.size(); ++i) {
    scan.points_m = world.scans[i];
    const Pose start = start_of(world, i);
    empty_caches();
    const double begin_ms = thread_cpu_ms();
    cutter.cut(localizer, scan, SensorProfile{}, look, start, cut);
    const MatchResult result = localize(localizer, cut, start, {.stop_step_m = kSampleStop_m});
    runs.add(thread_cpu_ms() - begin_ms, result.T_map_sensor.translation(), world.T_map_scan[i]);
  }
  return runs;
}

// Beside PCL's runs at 50 m, if there were any.
void compare_looks(const MatchWorld& world, const NdtMap& map, const Runs& peers) {
  const Localizer localizer = make_localizer(map, options_for_samples());
  std::vector<Runs> of_looks;
  const auto print = [&](const std::string& name, double ms, const Runs& runs) {
    std::printf("%4g m  %8.3f ms %7.1f x  %6.2f cm %3ld lost  %5.1f %5.1f %%  %s\n", map.cell_m, ms,
                median(peers.times_ms) / ms, 100.0 * median(runs.errors_m), runs.lost(),
                100.0 * runs.within(0.10), 100.0 * runs.within(0.25), name.c_str());
  };
  std::printf("cells  localization  faster  median error  within 10 and 25 cm  look\n");
  if (!peers.times_ms.empty()) print("PCL at 50 m", median(peers.times_ms), peers);
  for (const char* text : kLooks) {
    of_looks.push_back(run_look(world, localizer, *parse_look(text)));
    print(text, median(of_looks.back().times_ms), of_looks.back());
  }
  for (const double limit_m : {0.10, 0.25}) {
    std::vector<CoveredCost> answers;
    for (const Runs& runs : of_looks) {
      answers.push_back({runs.within(limit_m), median(runs.times_ms)});
    }
    if (peers.times_ms.empty()) continue;
    const CostAtCoverage equal = cost_at_coverage(answers, peers.within(limit_m));
    std::printf("%4g m  %8.3f ms %7.1f x  looks that cover %.1f %% within %g cm, as PCL does%s\n",
                map.cell_m, equal.cost, median(peers.times_ms) / equal.cost, 100.0 * equal.coverage,
                100.0 * limit_m, equal.is_reached ? "" : " not quite");
  }
}

NdtMap map_of(const MatchWorld& world, double cell_m) {
  BuildNdtOptions build;
  build.cell_m = cell_m;
  return ndt_from_points(world.map_points_m, MapFrame{}, build, 1);
}

void compare(const MatchWorld& world, double cell_m, bool has_peer) {
  const NdtMap map = map_of(world, cell_m);
  const NdtMap finest = map_of(world, kFinest_m);
  const int factor = static_cast<int>(cell_m / kFinest_m);
  std::vector<Method> methods;
  for (const char* name : {"plain", "annealed", "searching"}) {
    methods.push_back({name, make_localizer(map, localizer_named(name))});
  }
  methods.push_back(
      {"refined", make_localizer(finest, {.is_annealed = true, .coarse_cells = factor})});
  PclNdt pcl(world.map_points_m, cell_m);
  // The first match builds the tree of the raw map.
  pcl.set_scan(voxel_subsample(crop(world.scans[0], 10.0), world.leaf_m));
  if (has_peer) pcl.match(world.T_map_scan[0].matrix());
  Runs peers;
  for (const double range_m : {10.0, 30.0, 50.0}) {
    peers = {};
    std::vector<Runs> ours(methods.size());
    for (std::size_t i = 0; i < world.scans.size(); ++i) {
      const std::vector<Eigen::Vector3d> points_m =
          voxel_subsample(crop(world.scans[i], range_m), world.leaf_m);
      const Pose start = start_of(world, i);
      if (has_peer) run_pcl(pcl, points_m, start, world.T_map_scan[i], peers);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        run_ours(methods[m], points_m, start, world.T_map_scan[i], ours[m]);
      }
    }
    if (has_peer) print_row("PCL", cell_m, range_m, peers, peers);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      print_row(methods[m].name, cell_m, range_m, ours[m], peers);
    }
  }
  compare_looks(world, map, peers);
}

}  // namespace
}  // namespace sightline

// usage: match_bench [--ours]   (without PCL, whose matches take a minute or two)
int main(int argc, char** argv) {
  const bool has_peer = !(argc == 2 && std::string(argv[1]) == "--ours");
  const sightline::MatchWorld world = sightline::make_match_world();
  std::printf("%s: %zu scans, one start each, map of %zu points\n", world.name.c_str(),
              world.scans.size(), world.map_points_m.size());
  std::printf(
      "cells  range  method     one match  faster  median error   per point  faster  "
      "iterations / evaluations of all points\n");
  for (const double cell_m : {2.0, 1.0}) sightline::compare(world, cell_m, has_peer);
}
