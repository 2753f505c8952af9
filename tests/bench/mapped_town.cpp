#include "tests/bench/mapped_town.h"

#include <algorithm>
#include <utility>

#include "examples/town/drive/drive.h"
#include "formats/base/parallel.h"
#include "passes/map/build_ndt.h"

namespace sightline {
namespace {

constexpr double kBlock_m = 60.0;

std::vector<Eigen::Vector3d> points_of(const town::TownScan& scan, bool is_map) {
  std::vector<Eigen::Vector3d> points_m;
  for (const town::LabelledPoint& point : scan.points) {
    if (!is_map || !is_moving(point.label)) points_m.push_back(point.position_m.cast<double>());
  }
  return points_m;
}

NdtMap map_of(const town::DriveSimulator& drive, int threads) {
  const std::vector<Pose> T_map_given = drive.disturbed_poses();
  const std::vector<town::TownScan> scans = town::simulate(drive, threads);
  std::vector<Eigen::Vector3d> map_points_m;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Pose T_map_lidar = T_map_given[i] * drive.sensor().T_vehicle_lidar;
    for (const Eigen::Vector3d& p_m : points_of(scans[i], true)) {
      map_points_m.push_back(T_map_lidar * p_m);
    }
  }
  return ndt_from_points(map_points_m, MapFrame{}, BuildNdtOptions{}, threads);
}

town::TownChange rebuilt(double from_m, double to_m) {
  return {
      .from_m = from_m, .to_m = to_m, .removes_wall = false, .added_cars = 0, .noise_factor = 1.0};
}

town::DriveOptions harder_drive(const MappedTownOptions& options, std::uint64_t number,
                                const SensorProfile& sensor) {
  town::DriveOptions drive = town::usual_drive(options.town, number, sensor);
  drive.traffic = options.harder.traffic;
  drive.missing_share = options.harder.missing_share;
  return drive;
}

std::vector<town::TownScan> scans_between(const MappedTownOptions& options,
                                          const town::DriveOptions& drive, double from_m,
                                          double to_m) {
  const double left_m = 0.5 * (1.0 - options.harder.rebuilt_share) * (to_m - from_m);
  town::TownOptions changed = options.town;
  if (options.harder.rebuilt_share > 0.0) changed.change = rebuilt(from_m + left_m, to_m - left_m);
  const town::Town street = *town::make_town(changed);
  const town::DriveSimulator simulator = *town::DriveSimulator::make(street, drive);
  const auto first = static_cast<std::size_t>(from_m / drive.spacing_m);
  const std::size_t end = to_m >= options.town.length_m
                              ? simulator.scan_count()
                              : static_cast<std::size_t>(to_m / drive.spacing_m);
  return parallel_map<town::TownScan>(end - first, options.threads,
                                      [&](std::size_t i) { return simulator.scan(first + i); });
}

}  // namespace

TownDrive drive_through_town(const MappedTownOptions& options, std::uint64_t number,
                             const SensorProfile& sensor) {
  const town::DriveOptions harder = harder_drive(options, number, sensor);
  TownDrive drive;
  const double length_m = options.town.length_m;
  const double step_m = options.harder.rebuilt_share > 0.0 ? kBlock_m : length_m;
  for (double from_m = 0.0; from_m < length_m; from_m += step_m) {
    const double to_m = std::min(from_m + step_m, length_m);
    for (const town::TownScan& scan : scans_between(options, harder, from_m, to_m)) {
      drive.scans.emplace_back();
      drive.scans.back().points_m = points_of(scan, false);
      drive.T_map_vehicle.push_back(scan.T_town_vehicle);
    }
  }
  return drive;
}

MappedTown make_mapped_town(const MappedTownOptions& options) {
  MappedTown town;
  town.sensor = *town::town_sensor(options.beams);
  const town::Town street = *town::make_town(options.town);
  town.map =
      map_of(*town::DriveSimulator::make(street, town::usual_drive(options.town, 0, town.sensor)),
             options.threads);
  TownDrive judging = drive_through_town(options, 2, town.sensor);
  town.scans = std::move(judging.scans);
  town.T_map_vehicle = std::move(judging.T_map_vehicle);
  return town;
}

}  // namespace sightline
