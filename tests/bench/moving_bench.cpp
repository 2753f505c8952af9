// What does remove-moving take out of drives through generated towns, whose labels say what moved?
// `moving_bench [BEAMS=16] [LENGTH_M=300] [SEED=11 ...]`; poses are off by 2 cm as those of a good
// positioning system. Counted in the pass's own voxels: a voxel moved where more than half of its
// returns are of something that moves, else it stands; it is gone where the pass takes it out.

#include <cstdio>
#include <cstdlib>
#include <unordered_map>

#include "examples/town/drive/drive.h"
#include "examples/town/whole/town.h"
#include "formats/base/check.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/map/remove_moving.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr double kLaneM = 1.8;  // half the width of the driven lane

struct KeyHash {
  std::size_t operator()(const CellKey& key) const {
    return static_cast<std::size_t>(key.x) * 73856093U ^
           static_cast<std::size_t>(key.y) * 19349663U ^
           static_cast<std::size_t>(key.z) * 83492791U;
  }
};

struct Truth {
  std::uint32_t standing = 0;  // returns
  std::uint32_t cars = 0;
  std::uint32_t people = 0;
  bool is_on_lane = false;
  bool is_gone = false;

  [[nodiscard]] std::uint32_t moving() const { return cars + people; }
  [[nodiscard]] bool has_moved() const { return moving() > standing; }
};

using TruthByVoxel = std::unordered_map<CellKey, Truth, KeyHash>;

TruthByVoxel label_voxels(const town::DriveSimulator& drive, const Trajectory& trajectory,
                          double voxel_m) {
  TruthByVoxel truth;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Pose T_map_lidar = trajectory.poses[i].T_map_vehicle * drive.sensor().T_vehicle_lidar;
    for (const town::LabelledPoint& point : drive.scan(i).points) {
      Truth& voxel = truth[cell_key(T_map_lidar * point.position_m.cast<double>(), voxel_m)];
      if (point.label == town::Label::kMovingCar) {
        ++voxel.cars;
      } else if (point.label == town::Label::kPedestrian) {
        ++voxel.people;
      } else {
        ++voxel.standing;
      }
    }
  }
  return truth;
}

void mark_lane(const Trajectory& trajectory, double voxel_m, TruthByVoxel& truth) {
  for (auto& [key, voxel] : truth) {
    if (!voxel.has_moved()) continue;
    const Eigen::Vector2d at_m(key.x * voxel_m, key.y * voxel_m);
    for (const TrajectoryPose& pose : trajectory.poses) {
      const double away_m = (pose.T_map_vehicle.translation().head<2>() - at_m).norm();
      voxel.is_on_lane = voxel.is_on_lane || away_m < kLaneM;
    }
  }
}

void print_row(std::uint64_t seed, int beams, const TruthByVoxel& truth, double spent_s) {
  Share moved, cars, people, lane, kept;
  for (const auto& [key, voxel] : truth) {
    if (!voxel.has_moved()) {
      kept.count(!voxel.is_gone);
      continue;
    }
    moved.count(voxel.is_gone);
    (voxel.cars >= voxel.people ? cars : people).count(voxel.is_gone);
    if (voxel.is_on_lane) lane.count(voxel.is_gone);
  }
  std::printf("%5lu %5d %8.2f %8.2f %8.2f %8.2f %8.3f %8lu %8lu %6.1f\n",
              static_cast<unsigned long>(seed), beams, moved.percent(100.0), cars.percent(100.0),
              people.percent(100.0), lane.percent(100.0), kept.percent(100.0),
              static_cast<unsigned long>(moved.all), static_cast<unsigned long>(kept.all), spent_s);
}

Trajectory trajectory_of(const town::DriveSimulator& drive) {
  Trajectory trajectory;
  const std::vector<Pose> poses = drive.disturbed_poses();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    trajectory.poses.push_back({static_cast<std::uint32_t>(i), drive.stamp_ns(i), poses[i]});
  }
  return trajectory;
}

void measure(std::uint64_t seed, int beams, double length_m) {
  town::TownOptions options;
  options.seed = seed;
  options.length_m = length_m;
  const Result<town::Town> town = town::make_town(options);
  const Result<SensorProfile> sensor = town::town_sensor(beams);
  SIGHTLINE_CHECK(town && sensor);
  const town::DriveSimulator simulator =
      value_of(town::DriveSimulator::make(*town, town::usual_drive(options, 0, *sensor)));
  const Trajectory trajectory = trajectory_of(simulator);
  const Drive drive = town::recorded(simulator, "town", simulator.disturbed_poses(), 0);
  PassContext ctx;
  ctx.threads = 2;
  const double begin_s = cpu_s();
  const RemoveMovingOptions removal;
  const SurfacePoints points = value_of(remove_moving(ctx, removal, drive, trajectory));
  const double spent_s = cpu_s() - begin_s;
  TruthByVoxel truth = label_voxels(simulator, trajectory, removal.voxel_m);
  mark_lane(trajectory, removal.voxel_m, truth);
  for (const CellKey& key : points.moved_voxels) truth[key].is_gone = true;
  print_row(seed, beams, truth, spent_s);
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  const int beams = argc > 1 ? std::atoi(argv[1]) : 16;
  const double length_m = argc > 2 ? std::atof(argv[2]) : 300.0;
  std::printf(
      "of the voxels, %%: moving ones gone (of cars, people, on our lane), standing kept\n");
  std::printf("%5s %5s %8s %8s %8s %8s %8s %8s %8s %6s\n", "seed", "beams", "moving", "cars",
              "people", "lane", "standing", "moving", "standing", "cpu_s");
  for (int i = 3; i < argc; ++i) {
    sightline::measure(std::strtoull(argv[i], nullptr, 10), beams, length_m);
  }
  return 0;
}
