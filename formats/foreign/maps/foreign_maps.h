#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/grid/cell_key.h"
#include "formats/text/table.h"

namespace sightline {

// A piece of a point cloud map, one file.
struct PointMapFile {
  std::filesystem::path file;
  std::string name;  // within the map
  Digest content{};
  std::uint64_t content_xxh3 = 0;
  std::uint64_t point_count = 0;    // finite ones
  std::uint64_t dropped_count = 0;  // not finite, at (0,0,0), or withheld
  Eigen::AlignedBox3d box_m;        // of the points, in the map's own coordinates
};

// Somebody's finished point cloud map, opened but not held: it may be larger than memory.
struct PointMap {
  std::string name;
  std::vector<PointMapFile> files;  // in natural order of their names
  std::vector<std::string> warnings;
  Digest digest{};  // of names and contents: equal for equal maps, wherever they lie
};
SIGHTLINE_ARTIFACT(PointMap, "point-map", 1)

Result<void> validate(const PointMap& map);
Table dump(const PointMap& map);

// Opens a file (.pcd, .ply, .las, each also .gz), a folder of such files, or Autoware's map folder:
// one with pointcloud_map_metadata.yaml, which names the squares, beside them or above
// pointcloud_map.pcd/. Reads every file once, for its digest, `threads` (0: all) at a time. Errors:
// file-not-found (also a square of the metadata), empty-directory, mixed-formats, malformed-text
// (no square), unsupported-format (.bin; all points within a metre: degrees), and those of
// read_point_cloud.
Result<PointMap> open_point_map(const std::filesystem::path& path, int threads);

// The same files, but none is read: for lists of what a compile depends on.
Result<std::vector<std::filesystem::path>> list_point_map(const std::filesystem::path& path);

// Reads the pieces one at a time, in the map's own coordinates, without origins; index = position
// in map.files. Errors: mismatched-inputs (a file changed), and those of read_point_cloud.
std::shared_ptr<const ScanStore> point_map_store(const PointMap& map);

// A cell of somebody's NDT map.
struct ForeignNd {
  CellKey key_world;               // of the grid that begins at the world's origin
  std::uint32_t point_count = 0;   // 2 or more
  Eigen::Vector3d mean_in_cell_m;  // from the cell's lower corner, inside the cell
  Eigen::Matrix3d covariance_m2;   // raw, divided by n - 1
};

// Somebody's finished NDT map: cells and no points. Means are kept beside their cells, since a
// world of UTM is millions of metres wide.
struct ForeignNds {
  std::string name;
  std::string world = "local";  // that the map says it lies in (formats/geodesy.h, parse_world)
  double cell_m = 0.0;
  std::vector<ForeignNd> nds;            // ascending by key, each key once
  std::uint64_t single_point_count = 0;  // cells of fewer than 2 points, which are left out
  std::uint64_t point_count = 0;         // of all cells, those left out too
  std::vector<std::string> warnings;
  Digest digest{};  // of names and contents: equal for equal maps, wherever they lie
};

template <>
struct ArtifactTraits<ForeignNds> {
  static constexpr std::string_view kName = "foreign-nds";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const ForeignNds& map);
Table dump(const ForeignNds& map);

}  // namespace sightline
