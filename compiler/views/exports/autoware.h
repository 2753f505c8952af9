#pragma once

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
// Coordinates are the world's, less the whole 100 km of export_origin_m(): in a local world with
// the projector Local, in one of UTM or MGRS with MGRS and the square that they count from, in an
// ENU world with LocalCartesian, the altitude of whose origin is 0.
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

// Errors: bad-argument (the frame's origin is no point of the world named, or lies 100 km or more
// from that of an ENU world), empty-map (no points).
Result<AutowareMap> autoware_map(const std::vector<Eigen::Vector3d>& points_map_m,
                                 const MapFrame& frame, const World& world);

}  // namespace sightline
