// Localizes one scan with PCL's NDT, looking as far as a compiled map says for that place:
//
//   vehicle_pcl MAP CLOUD SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M [LOCALIZER]]
//
// MAP is the compiled map, CLOUD the points it was made of, a PCD file or an Autoware map
// (`sightline export town.yaml --format autoware -o CLOUD`), SCAN a PCD file in the sensor's frame.
// The rest is a guess of the sensor's pose in the world the map was made in, level, good to about a
// metre and a few degrees. LIMIT_M is the accuracy that is needed, 0.10 m unless given. LOCALIZER
// is the name under which this vehicle's errors were measured, "vehicle-pcl" unless given: a map of
// another localizer's errors knows no range for it, and it looks as far as the map goes. What it
// runs here is PCL's NDT on voxels of 1 m; "pcl-ndt" is the same matcher with Autoware's numbers
// (schemas/definitions.md, "Localizers").

#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>
#include <pcl/registration/ndt.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>

#include "formats/reader/pcl.h"
#include "formats/reader/reader.h"

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using sightline::MapReader;
using sightline::RangeAnswer;
using sightline::Result;

constexpr float kLeaf_m = 1.0F;  // voxel of the thinned scan
constexpr float kCell_m = 2.0F;  // of the NDT grid

int refuse(const sightline::Error& error) {
  std::fprintf(stderr, "%s\n", to_string(error).c_str());
  return sightline::exit_status(error.code);
}

Cloud::Ptr load(const std::filesystem::path& path) {
  const Cloud::Ptr cloud(new Cloud);
  if (pcl::io::loadPCDFile(path.string(), *cloud) != 0) return nullptr;
  return cloud;
}

// All squares of an Autoware map, or one file.
Cloud::Ptr load_map(const std::filesystem::path& path) {
  const std::filesystem::path squares = path / "pointcloud_map.pcd";
  if (!std::filesystem::is_directory(squares)) return load(path);
  const Cloud::Ptr all(new Cloud);
  for (const std::filesystem::directory_entry& entry :
       std::filesystem::directory_iterator(squares)) {
    const Cloud::Ptr square = load(entry.path());
    if (square == nullptr) return nullptr;
    *all += *square;
  }
  return all;
}

Cloud::Ptr thinned(const Cloud& cloud) {
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(kLeaf_m, kLeaf_m, kLeaf_m);
  grid.setInputCloud(cloud.makeShared());
  const Cloud::Ptr result(new Cloud);
  grid.filter(*result);
  return result;
}

struct Guess {
  std::array<double, 3> position_world_m{};
  double yaw_rad = 0.0;
};

int localize(const MapReader& map, const Cloud::Ptr& target, const Cloud& scan, const Guess& guess,
             double limit_m) {
  const Result<RangeAnswer> answer = map.observation_range(guess.position_world_m, limit_m);
  if (!answer) return refuse(answer.error());
  if ((answer->flags & sightline::kAnswerUnknownLocalizer) != 0) {
    std::fprintf(stderr, "the map's errors are those of %s: they are unknown for this localizer\n",
                 std::string(map.info().localizer).c_str());
  }
  const Cloud::Ptr source = thinned(crop(scan, *answer));
  // The cloud lies in the world, less the whole 100 km that floats do not hold.
  Eigen::Affine3d T_map_sensor = Eigen::Affine3d::Identity();
  const Eigen::Vector3d origin_world_m(map.info().export_origin_world_m.data());
  T_map_sensor.translation() = Eigen::Vector3d(guess.position_world_m.data()) - origin_world_m;
  T_map_sensor.rotate(Eigen::AngleAxisd(guess.yaw_rad, Eigen::Vector3d::UnitZ()));

  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setResolution(kCell_m);
  ndt.setTransformationEpsilon(1e-4);
  ndt.setMaximumIterations(50);
  ndt.setInputTarget(target);
  ndt.setInputSource(source);
  const auto begin = std::chrono::steady_clock::now();
  Cloud moved;
  ndt.align(moved, T_map_sensor.matrix().cast<float>());
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;

  const Eigen::Matrix4d T_map_found = ndt.getFinalTransformation().cast<double>();
  const Eigen::Vector3d place_m = T_map_found.block<3, 1>(0, 3) + origin_world_m;
  const double yaw_rad = std::atan2(T_map_found(1, 0), T_map_found(0, 0));
  std::printf("range_m %g probability %.4f\n", answer->range_m, answer->probability);
  std::printf("position_world_m %.4f %.4f %.4f\n", place_m.x(), place_m.y(), place_m.z());
  std::printf("yaw_deg %.4f\n", yaw_rad * 180.0 / std::numbers::pi);
  std::printf("iterations %d points %zu time_ms %.1f\n", ndt.getFinalNumIteration(), source->size(),
              spent.count());
  return ndt.hasConverged() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 8 || argc > 10) {
    std::fprintf(stderr, "usage: %s MAP CLOUD SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M [LOCALIZER]]\n",
                 argv[0]);
    return 64;
  }
  const Result<MapReader> map = MapReader::open(argv[1], argc == 10 ? argv[9] : "vehicle-pcl");
  if (!map) return refuse(map.error());
  const Cloud::Ptr target = load_map(argv[2]);
  const Cloud::Ptr scan = load(argv[3]);
  if (target == nullptr || scan == nullptr) return 65;  // PCL has said why
  const Guess guess{{std::atof(argv[4]), std::atof(argv[5]), std::atof(argv[6])},
                    std::atof(argv[7]) * std::numbers::pi / 180.0};
  return localize(*map, target, *scan, guess, argc >= 9 ? std::atof(argv[8]) : 0.10);
}
