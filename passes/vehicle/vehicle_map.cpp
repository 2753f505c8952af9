#include "passes/vehicle/vehicle_map.h"

#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "formats/base/files/regular_file.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/map/map_reader.h"
#include "formats/reader/map_layout.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/localizer.h"

namespace sightline {
namespace {

constexpr double kCellsOfTile = 32.0;
constexpr double kMostCells = 0x1.0p29;

bool is_own(const LocalizerProfile& profile) {
  return profile.name == localizer_name(LocalizerKind::kPlain) ||
         profile.name == localizer_name(LocalizerKind::kAnnealed) ||
         profile.name == localizer_name(LocalizerKind::kSearching);
}

double longest_look_m(const CompiledMap& map) {
  double longest_m = 0.0;
  for (const Look& look : map.ranges.looks) longest_m = std::max(longest_m, look.range_m);
  if (!map.looks) return longest_m;
  for (const Look& look : map.looks->ranges.looks) longest_m = std::max(longest_m, look.range_m);
  return longest_m;
}

// `map` may be without NDs.
VehicleMap vehicle_map_of(const CompiledMap& map) {
  VehicleMap result;
  result.ndt = map.ndt;
  result.sensor = map.sensor;
  result.longest_look_m = longest_look_m(map);
  result.is_small = map.size == MapSize::kPromise;
  const LocalizerProfile& measured = map.measurement.localizer;
  if (!is_own(measured)) return result;
  result.localizer = measured.name;
  result.coarse_cells = static_cast<int>(map.measurement.coarse_cells);
  result.leaf_m = map.measurement.leaf_m;
  result.takes_every_return = took_every_return(measured);
  return result;
}

// By which kind_at() finds kinds of places. A map may have none.
Result<void> open_kinds(const std::filesystem::path& path, VehicleMap& map) {
  SIGHTLINE_ASSIGN(map.reader, MapReader::open(path.string(), map.localizer));
  const Result<MapColumn> kinds = map.reader->column(kPlaceKindColumn);
  if (kinds) map.kinds = *kinds;
  if (!kinds && kinds.error().code != ErrorCode::kBadArgument) return kinds.error();
  return {};
}

Result<VehicleMap> read_compiled(const std::filesystem::path& path, bool is_whole) {
  if (is_whole) {
    SIGHTLINE_ASSIGN(CompiledMap map, read_map(path));
    NdtMap ndt = std::move(map.ndt);
    map.ndt = {};
    VehicleMap result = vehicle_map_of(map);
    result.ndt = std::move(ndt);
    SIGHTLINE_TRY(open_kinds(path, result));
    return result;
  }
  SIGHTLINE_ASSIGN(MapTiles tiles, MapTiles::open(path));
  VehicleMap result = vehicle_map_of(tiles.head());
  result.tiles = std::make_unique<const MapTiles>(std::move(tiles));
  SIGHTLINE_TRY(open_kinds(path, result));
  return result;
}

// In the order of the files.
Result<std::vector<Eigen::Vector3d>> read_points(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> files = {path};
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    SIGHTLINE_ASSIGN(files, list_scan_files(path));
  }
  std::vector<Eigen::Vector3d> points_m;
  for (const std::filesystem::path& file : files) {
    SIGHTLINE_ASSIGN(const PointCloudFile cloud, read_point_cloud(file));
    points_m.insert(points_m.end(), cloud.points_m.begin(), cloud.points_m.end());
  }
  return points_m;
}

Result<VehicleMap> read_cloud(const std::filesystem::path& path, const VehicleMapOptions& options) {
  SIGHTLINE_ASSIGN(std::vector<Eigen::Vector3d> points_m, read_points(path));
  Eigen::Vector3d low_m = points_m.front();
  Eigen::Vector3d high_m = low_m;
  for (const Eigen::Vector3d& point_m : points_m) {
    low_m = low_m.cwiseMin(point_m);
    high_m = high_m.cwiseMax(point_m);
  }
  const double tile_m = kCellsOfTile * options.cell_m;
  const double reach_m = kMostCells * options.cell_m;
  if (!(low_m.cwiseAbs().maxCoeff() < reach_m && high_m.cwiseAbs().maxCoeff() < reach_m)) {
    return Error{ErrorCode::kUnsupportedFormat,
                 "a point is more than 2^29 cells from the origin. Give coordinates in metres",
                 path.string()};
  }
  const MapFrame frame = frame_near(low_m, tile_m);
  for (Eigen::Vector3d& point_m : points_m) point_m -= frame.origin_world_m;
  VehicleMap map;
  map.ndt = ndt_from_points(
      points_m, frame,
      {.cell_m = options.cell_m, .tile_m = tile_m, .min_points = options.min_points},
      options.threads);
  if (!map.ndt.nds.empty()) return map;
  return Error{
      ErrorCode::kEmptyMap,
      concat("none of ", map.ndt.sparse_cell_count, " cells of ", std::to_string(options.cell_m),
             " m has ", options.min_points, " points. Use a denser cloud or larger cells"),
      path.string()};
}

Result<VehicleMap> read_either(const std::filesystem::path& path,
                               const VehicleMapOptions& options) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return read_cloud(path, options);
  SIGHTLINE_ASSIGN(const std::string beginning,
                   read_beginning(path.string(), kMapBeginning.size()));
  const bool is_map =
      path.extension() == ".slmap" || beginning.starts_with(kMapBeginning.substr(0, 4));
  return is_map ? read_compiled(path, options.is_whole) : read_cloud(path, options);
}

Result<void> check(const VehicleMapOptions& options) {
  const double azimuth_step_deg = options.azimuth_step_deg.value_or(0.2);
  const bool is_good = options.cell_m >= 0.1 && options.cell_m <= 100.0 &&
                       options.min_points >= 3 && options.threads >= 0 && azimuth_step_deg > 0.0 &&
                       azimuth_step_deg <= 10.0 &&
                       is_rigid(options.T_vehicle_sensor.value_or(Pose::Identity()));
  if (is_good) return {};
  return Error{
      ErrorCode::kBadValue,
      "expected cells of 0.1 to 100 m, 3 points or more, 0 threads or more, an azimuth step of at "
      "most 10 degrees and a mounting of the sensor that is a rotation and a translation",
      "", "options of the localizer"};
}

}  // namespace

PlaceKind kind_at(const VehicleMap& map, const Pose& T_map_vehicle) {
  if (!map.reader || map.kinds.values.empty()) return PlaceKind::kUnknown;
  const Eigen::Vector3d p_world_m =
      (T_map_vehicle * map.sensor.T_vehicle_lidar).translation() + map.ndt.frame.origin_world_m;
  const Result<RangeAnswer> nearest = map.reader->observation_range(
      {p_world_m.x(), p_world_m.y(), p_world_m.z()}, map.reader->info().limits_m.front());
  if (!nearest || nearest->site == kNoSite || nearest->distance_m > map.reader->info().reach_m) {
    return PlaceKind::kUnknown;
  }
  return place_kind_of(map.kinds.values[nearest->site]);
}

Result<VehicleMap> read_vehicle_map(const std::filesystem::path& path,
                                    const VehicleMapOptions& options) {
  SIGHTLINE_TRY(check(options));
  SIGHTLINE_ASSIGN(VehicleMap map, read_either(path, options));
  if (options.azimuth_step_deg) map.sensor.azimuth_step_deg = *options.azimuth_step_deg;
  if (options.T_vehicle_sensor) map.sensor.T_vehicle_lidar = *options.T_vehicle_sensor;
  return map;
}

}  // namespace sightline
