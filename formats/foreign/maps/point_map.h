#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
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
// pointcloud_map.pcd/. Every file is read once here, `threads` (0: all) at a time, so that the
// digest names what later passes will see.
// Errors: file-not-found (also a square that the metadata name), empty-directory, mixed-formats,
// malformed-text (metadata that name no square), unsupported-format (.bin, which is no map; all
// points within a metre of each other: degrees), and those of read_point_cloud.
Result<PointMap> open_point_map(const std::filesystem::path& path, int threads);

// The same files, but none is read: for lists of what a compile depends on.
Result<std::vector<std::filesystem::path>> list_point_map(const std::filesystem::path& path);

// Reads the pieces one at a time, in the map's own coordinates; index = position in map.files. No
// piece has an origin that it was seen from. Error: mismatched-inputs where a file is not the one
// that was opened, and those of read_point_cloud.
std::shared_ptr<const ScanStore> point_map_store(const PointMap& map);

}  // namespace sightline
