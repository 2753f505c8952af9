// Localizes one scan in a compiled map, with the compiler's own matcher, looking as far as the map
// says for that place:
//
//   vehicle_localize MAP SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M]
//
// SCAN is a point cloud file in the sensor's frame. The rest is a guess of the sensor's pose in the
// world the map was made in, level, good to about a metre and a few degrees. LIMIT_M is the
// accuracy that is needed, 0.10 m unless given.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "formats/base/portable_math.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/map/map_reader.h"
#include "formats/reader/reader.h"
#include "passes/matching/localizer.h"

namespace {

using namespace sightline;

// What this vehicle matches with. A map of another localizer's errors knows no range for it.
constexpr const char* kLocalizer = "searching";
constexpr double kLeaf_m = 1.0;  // the voxel that errors were measured with

int refuse(const Error& error) {
  std::fprintf(stderr, "%s\n", to_string(error).c_str());
  return exit_status(error.code);
}

Pose level_pose(const std::array<double, 3>& position_m, double yaw_deg) {
  const SinCos yaw = portable_sin_cos(yaw_deg * 3.14159265358979323846 / 180.0);
  Pose pose = Pose::Identity();
  pose.linear() << yaw.cos, -yaw.sin, 0.0, yaw.sin, yaw.cos, 0.0, 0.0, 0.0, 1.0;
  pose.translation() << position_m[0], position_m[1], position_m[2];
  return pose;
}

void print(const RangeAnswer& range, const MatchResult& result, std::size_t point_count,
           const Pose& T_world_vehicle) {
  const Eigen::Vector3d place_m = T_world_vehicle.translation();
  const Eigen::Quaterniond turn(T_world_vehicle.linear());
  std::printf("range_m %g probability %.4f\n", range.range_m, range.probability);
  std::printf("stop %s\n", std::string(to_text(result.stop)).c_str());
  std::printf("position_world_m %.4f %.4f %.4f\n", place_m.x(), place_m.y(), place_m.z());
  std::printf("quaternion_xyzw %.6f %.6f %.6f %.6f\n", turn.x(), turn.y(), turn.z(), turn.w());
  std::printf("score %.3f nearest_voxel_likelihood %.4f\n", result.score,
              result.nearest_voxel_likelihood);
  std::printf("iterations %d points %zu scored %u work %llu\n", result.iterations, point_count,
              result.scored_points, static_cast<unsigned long long>(result.work));
  // How the score says that the error is spread: it ranks places and is no accuracy.
  std::printf("covariance_xyz_m2");
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) std::printf(" %.3e", result.covariance(i, j));
  }
  std::printf("\n");
}

int localize_scan(const char* map_path, const char* scan_path, const Pose& T_world_guess,
                  double limit_m) {
  const Result<CompiledMap> map = read_map(map_path);
  if (!map) return refuse(map.error());
  const Pose& T_vehicle_lidar = map->sensor.T_vehicle_lidar;
  const Eigen::Vector3d sensor_m = T_world_guess * T_vehicle_lidar.translation();
  const Result<MapReader> reader = MapReader::open(map_path, kLocalizer);
  if (!reader) return refuse(reader.error());
  const Result<RangeAnswer> range =
      reader->observation_range({sensor_m.x(), sensor_m.y(), sensor_m.z()}, limit_m);
  if (!range) return refuse(range.error());
  Result<PointCloudFile> cloud = read_point_cloud(scan_path);
  if (!cloud) return refuse(cloud.error());

  const Localizer localizer = make_localizer(map->ndt, localizer_named(kLocalizer));
  ScanCutter cutter;  // a vehicle keeps it from scan to scan
  ScanForMatch scan =
      make_scan_for_match(localizer, cutter, {.points_m = std::move(cloud->points_m)}, map->sensor,
                          {range->range_m, kLeaf_m});
  // The matcher works in the map's frame, near its origin.
  const MapFrame world;
  const MatchResult result =
      localize(localizer, scan, rebase(T_world_guess, world, map->ndt.frame));
  print(*range, result, scan.points_m.size(), rebase(result.T_map_sensor, map->ndt.frame, world));
  return result.stop == MatchStop::kNoPoints || result.stop == MatchStop::kNoOverlap ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7 || argc > 8) {
    std::fprintf(stderr, "usage: %s MAP SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M]\n", argv[0]);
    return 64;
  }
  const Pose T_world_guess =
      level_pose({std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5])}, std::atof(argv[6]));
  const double limit_m = argc == 8 ? std::atof(argv[7]) : 0.10;
  return localize_scan(argv[1], argv[2], T_world_guess, limit_m);
}
