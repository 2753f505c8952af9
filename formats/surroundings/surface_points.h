#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/artifact.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/geometry.h"
#include "formats/grid/cell_index.h"
#include "formats/record/fields.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// A scan of a drive in the map: its returns between the two ranges belong there.
struct PlacedScan {
  std::uint32_t index = 0;  // of the drive's scans
  Pose T_map_lidar = Pose::Identity();
  double min_range_m = 0.0;
  double max_range_m = 0.0;
  std::uint32_t part = 0;  // of the drive
};
SIGHTLINE_FIELDS(PlacedScan, index, T_map_lidar, min_range_m, max_range_m, part)
inline bool is_within_range(const PlacedScan& scan, const Eigen::Vector3d& point_lidar_m) {
  const double range_m = point_lidar_m.norm();
  return range_m >= scan.min_range_m && range_m <= scan.max_range_m;
}

// Names what scans give that lie so, after what `before` holds. Nothing where a scan is not known
// without reading it.
std::optional<Digest> content_of_scans(const ScanStore& store, std::span<const PlacedScan> scans,
                                       ByteWriter before);

// What stood still: the returns of a mapping drive in the map frame, without what moved. They may
// be more than memory holds, so a recording's are not here but read again scan by scan (see
// SurfacePointReader); here is which voxels moved.
struct SurfacePoints {
  MapFrame frame;
  // Points in memory, made by tests and benchmarks. Empty for recordings and for finished maps,
  // whose files are `scans`.
  std::vector<Eigen::Vector3d> points_m;
  std::vector<PlacedScan> scans;           // in the drive's order
  double voxel_m = 0.0;                    // edge of a voxel; 0 when nothing was looked for
  std::vector<CellKey> moved_voxels;       // ascending: what was removed
  std::uint64_t standing_count = 0;        // returns in range that stood still
  std::uint64_t moving_count = 0;          // returns in voxels that moved
  std::uint64_t out_of_range_count = 0;    // outside the sensor's minimum and maximum range
  std::shared_ptr<const ScanStore> store;  // of the drive; not encoded, see reattach
};
SIGHTLINE_SOME_FIELDS(SurfacePoints, frame, points_m, scans, voxel_m, moved_voxels, standing_count,
                      moving_count, out_of_range_count)
SIGHTLINE_ARTIFACT(SurfacePoints, "surface-points", 3)

// Says nothing about the store.
Result<void> validate(const SurfacePoints& points);
// The points that lie in memory, and the centres of the voxels that moved.
Table dump(const SurfacePoints& points);

// After decode: gives the points back the scans that they are read from.
void reattach(SurfacePoints& points, const Drive& drive, const Trajectory& trajectory);

// Names what SurfacePointReader gives of these parts, after what `before` holds: scans, where they
// lie, and what moved. Nothing where a part is not known without reading it.
std::optional<Digest> content_of_parts(const SurfacePoints& points,
                                       std::span<const std::size_t> parts, ByteWriter before);
// The same of what it gives in this part of the plane of the map, and which scans give it.
std::optional<Digest> content_of_parts(const SurfacePoints& points,
                                       std::span<const std::size_t> parts,
                                       const Eigen::AlignedBox2d& within_m, ByteWriter before);

// What one part of surface points gives, whether it stood or moved.
struct ReturnsInMap {
  std::vector<Eigen::Vector3d> points_m;  // map frame, in the part's order
  std::vector<std::uint8_t> has_moved;  // 1 for each point in a voxel that moved; none: no point is
};

// Reads surface points part by part. Keeps a reference to them.
class SurfacePointReader {
 public:
  explicit SurfacePointReader(const SurfacePoints& points);
  // One that is asked for these parts alone: it remembers no voxel that their rays do not reach.
  SurfacePointReader(const SurfacePoints& points, std::span<const std::size_t> parts);
  // A reader of these parts within a rectangle of the map's plane: standing() and moving() return
  // only points in it. all() returns the points outside too, each with has_moved 0.
  SurfacePointReader(const SurfacePoints& points, std::span<const std::size_t> parts,
                     const Eigen::AlignedBox2d& within_m);

  // The scans and, last, what lies in memory if anything does.
  [[nodiscard]] std::size_t part_count() const;
  // Standing points of one part in the map frame, in the part's order; and those that moved. Safe
  // from several threads. Errors: what reading a scan says.
  [[nodiscard]] Result<std::vector<Eigen::Vector3d>> standing(std::size_t part) const;
  [[nodiscard]] Result<std::vector<Eigen::Vector3d>> moving(std::size_t part) const;
  [[nodiscard]] Result<ReturnsInMap> all(std::size_t part) const;

 private:
  // The points of one kind, within.
  [[nodiscard]] std::vector<Eigen::Vector3d> chosen_m(ReturnsInMap returns,
                                                      std::uint8_t has_moved) const;

  const SurfacePoints& points_;
  Eigen::AlignedBox2d within_m_;
  CellSet moved_;
};

}  // namespace sightline
