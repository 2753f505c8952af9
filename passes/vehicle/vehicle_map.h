#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/drive/localizer_profile.h"
#include "formats/drive/sensor_profile.h"
#include "formats/grid/point_grid.h"
#include "formats/model/place_kind.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// What a vehicle localizes in, and how.
struct VehicleMap {
  NdtMap ndt;
  SensorProfile sensor;                 // of the localizing drive; of a cloud the default one
  std::string localizer = "searching";  // one of this program's own, PCL's aside
  int coarse_cells = 1;
  double leaf_m = 1.0;
  bool takes_every_return = false;
  PointGrid sites;                    // by the sensor's place; of a cloud none
  std::vector<PlaceKind> site_kinds;  // [site]
  double reach_m = 0.0;               // of a site
};

// Of the site nearest to a vehicle there; unknown beyond its reach.
PlaceKind kind_at(const VehicleMap& map, const Pose& T_map_vehicle);

struct VehicleMapOptions {
  // Of the NDs that are made of a point cloud, as build-ndt makes them.
  double cell_m = 2.0;
  int min_points = 10;
  int threads = 0;  // 0: all there are
  // Of the sensor, where they are not the map's.
  std::optional<double> azimuth_step_deg;
  std::optional<Pose> T_vehicle_sensor;
};

// A compiled map with the localizer whose errors it holds (searching, where that is no own one), or
// a point cloud or a folder of clouds, of which the NDs are computed: the map's frame is then that
// of the lowest corner of all points, the world that of the files.
// Errors: those of read_map(), read_point_cloud(), list_scan_files(); empty-map (no cell has points
// enough), unsupported-format (points farther apart than 2^29 cells), bad-value (an option).
Result<VehicleMap> read_vehicle_map(const std::filesystem::path& path,
                                    const VehicleMapOptions& options);

}  // namespace sightline
