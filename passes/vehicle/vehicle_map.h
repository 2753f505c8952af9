#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "formats/drive/localizer_profile.h"
#include "formats/drive/sensor_profile.h"
#include "formats/map/tiles/map_tiles.h"
#include "formats/model/place_kind.h"
#include "formats/reader/reader.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// What a vehicle localizes in, and how.
struct VehicleMap {
  NdtMap ndt;                             // without NDs where `tiles` has them
  std::unique_ptr<const MapTiles> tiles;  // of a compiled map that is not read whole
  double longest_look_m = 50.0;           // of the map's looks
  SensorProfile sensor;                   // of the localizing drive; of a cloud the default one
  std::string localizer = "searching";    // one of this program's own, PCL's aside
  int coarse_cells = 1;
  double leaf_m = 1.0;
  bool takes_every_return = false;
  bool is_small = false;            // without the NDs that no look of its plan needs
  std::optional<MapReader> reader;  // of a compiled map: finds the site that is nearest
  MapColumn kinds;                  // of its sites; empty where they have none
};

// Of the site nearest to a vehicle there; unknown beyond its reach. Allocates nothing.
PlaceKind kind_at(const VehicleMap& map, const Pose& T_map_vehicle);

struct VehicleMapOptions {
  // Of the NDs that are made of a point cloud, as build-ndt makes them.
  double cell_m = 2.0;
  int min_points = 10;
  int threads = 0;       // 0: all there are
  bool is_whole = true;  // a compiled map is read and checked whole, else tile by tile when needed
  // Of the sensor, where they are not the map's.
  std::optional<double> azimuth_step_deg;
  std::optional<Pose> T_vehicle_sensor;
};

// A compiled map with the localizer whose errors it holds (searching, where that is no own one), or
// a point cloud or a folder of clouds, of which the NDs are computed: the map's frame is then that
// of the lowest corner of all points, the world that of the files.
// Errors: those of read_map(), MapTiles::open(), read_point_cloud(), list_scan_files(); empty-map
// (no cell has points enough), unsupported-format (points farther apart than 2^29 cells), bad-value
// (an option).
Result<VehicleMap> read_vehicle_map(const std::filesystem::path& path,
                                    const VehicleMapOptions& options);

}  // namespace sightline
