#include "tests/bench/mapped_town.h"

#include "examples/town/drive.h"
#include "passes/map/build_ndt.h"

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> points_of(const town::TownScan& scan, bool is_map) {
  std::vector<Eigen::Vector3d> points_m;
  for (const town::LabelledPoint& point : scan.points) {
    if (!is_map || !is_moving(point.label)) points_m.push_back(point.position_m.cast<double>());
  }
  return points_m;
}

}  // namespace

MappedTown make_mapped_town(const town::TownOptions& options, int beams, int threads) {
  const town::Town street = *town::make_town(options);
  MappedTown town;
  town.sensor = *town::town_sensor(beams);
  const auto drive = [&](std::uint64_t number) {
    return *town::DriveSimulator::make(street, town::usual_drive(options, number, town.sensor));
  };
  const town::DriveSimulator mapping = drive(0);
  town.sensor = mapping.sensor();
  const std::vector<Pose> T_map_given = mapping.disturbed_poses();
  const std::vector<town::TownScan> mapped = town::simulate(mapping, threads);
  std::vector<Eigen::Vector3d> map_points_m;
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    const Pose T_map_lidar = T_map_given[i] * town.sensor.T_vehicle_lidar;
    for (const Eigen::Vector3d& p_m : points_of(mapped[i], true)) {
      map_points_m.push_back(T_map_lidar * p_m);
    }
  }
  town.map = ndt_from_points(map_points_m, MapFrame{}, BuildNdtOptions{}, threads);
  for (const town::TownScan& scan : town::simulate(drive(2), threads)) {
    town.scans.emplace_back();
    town.scans.back().points_m = points_of(scan, false);
    town.T_map_vehicle.push_back(scan.T_town_vehicle);
  }
  return town;
}

}  // namespace sightline
