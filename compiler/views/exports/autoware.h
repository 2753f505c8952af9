#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/geodesy.h"
#include "formats/geometry.h"

namespace sightline {

// A map directory as Autoware's loaders take it: pointcloud_map.pcd/X_Y.pcd, squares of 20 m that
// are named by their lower corner and do not overlap; pointcloud_map_metadata.yaml, which gives
// each its corner; map_projector_info.yaml. The vector map (lanelet2_map.osm) is for others to
// draw.
//
// Coordinates: in a local world and in one of UTM, x and y of the map frame (projectors Local,
// and LocalCartesianUTM about the frame's origin) and z of the world; in an ENU world those of the
// world (LocalCartesian). In the last two the altitude of Autoware's origin is 0.
inline constexpr double kAutowareSquare_m = 20.0;

struct AutowareSquare {
  std::string file;  // "-20_40.pcd"
  int x_m = 0;       // lower corner
  int y_m = 0;
  std::vector<PointXyzi> points;
};

struct AutowareMap {
  std::vector<AutowareSquare> squares;  // ascending by (x, y)
  std::string metadata_yaml;
  std::string projector_yaml;
};

// Errors: bad-argument (the frame's origin is no point of the world named), empty-map (no points).
Result<AutowareMap> autoware_map(const std::vector<Eigen::Vector3d>& points_map_m,
                                 const MapFrame& frame, const World& world);

}  // namespace sightline
