#include "formats/surroundings/surface_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "formats/base/check.h"

namespace sightline {
namespace {

Result<void> validate(const PlacedScan& scan, const std::string& place) {
  if (!is_rigid(scan.T_map_lidar)) {
    return invalid_artifact("its pose is not a rotation and translation", place);
  }
  if (!(scan.min_range_m >= 0.0 && scan.max_range_m >= scan.min_range_m)) {
    return invalid_artifact("its minimum and maximum range are out of order", place);
  }
  return {};
}

constexpr double kSlack_m = 0.01;  // more than rounding moves

// The plane that the rays of these parts reach.
Eigen::AlignedBox2d reach_of_m(const SurfacePoints& points, std::span<const std::size_t> parts) {
  Eigen::AlignedBox2d reach_m;
  for (const std::size_t part : parts) {
    if (part >= points.scans.size()) continue;  // lies in memory: nothing of it moved
    const PlacedScan& scan = points.scans[part];
    const Eigen::Vector2d origin_m = scan.T_map_lidar.translation().head<2>();
    const Eigen::Vector2d range_m =
        Eigen::Vector2d::Constant(scan.max_range_m + points.voxel_m + kSlack_m);
    reach_m.extend(origin_m - range_m);
    reach_m.extend(origin_m + range_m);
  }
  return reach_m;
}

// Those with a centre in this part of the plane, ascending.
std::vector<CellKey> moved_voxels_within(const SurfacePoints& points,
                                         const Eigen::AlignedBox2d& plane_m) {
  if (points.moved_voxels.empty() || plane_m.isEmpty()) return {};
  // Ascending by x.
  const auto begin = std::ranges::partition_point(points.moved_voxels, [&](const CellKey& key) {
    return cell_centre_m(key.x, points.voxel_m) < plane_m.min().x();
  });
  std::vector<CellKey> within;
  for (auto key = begin; key != points.moved_voxels.end(); ++key) {
    if (cell_centre_m(key->x, points.voxel_m) > plane_m.max().x()) break;
    if (plane_m.contains(cell_centre_m(*key, points.voxel_m).head<2>())) within.push_back(*key);
  }
  return within;
}

// Tells of most returns within a scan's ranges that they are, without a square root.
class SureRange {
 public:
  explicit SureRange(const PlacedScan& scan)
      : low_m2_(scan.min_range_m * scan.min_range_m * (1.0 + kSlack)),
        high_m2_(scan.max_range_m * scan.max_range_m * (1.0 - kSlack)) {}
  [[nodiscard]] bool holds(const Eigen::Vector3d& point_lidar_m) const {
    const double range_m2 = point_lidar_m.squaredNorm();
    return range_m2 > low_m2_ && range_m2 < high_m2_;
  }

 private:
  static constexpr double kSlack = 1e-12;  // far more than rounding moves
  double low_m2_, high_m2_;
};

Eigen::AlignedBox2d whole_plane_m() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {Eigen::Vector2d::Constant(-kInfinity), Eigen::Vector2d::Constant(kInfinity)};
}

Eigen::AlignedBox2d widened_m(const Eigen::AlignedBox2d& box_m, double by_m) {
  const Eigen::Vector2d slack_m = Eigen::Vector2d::Constant(by_m);
  return {box_m.min() - slack_m, box_m.max() + slack_m};
}

// For each point within the box, whether it lies in the cells; 0 for the others.
std::vector<std::uint8_t> which_lie_in(const CellSet& cells, double cell_m,
                                       std::span<const Eigen::Vector3d> points_m,
                                       const Eigen::AlignedBox2d& within_m) {
  std::vector<std::uint8_t> is_inside(points_m.size());
  std::array<CellKey, 256> keys;
  // Neighbours on a ring lie in one cell more often than not.
  std::optional<CellKey> last;
  std::uint8_t is_last_inside = 0;
  for (std::size_t first = 0; first < points_m.size(); first += keys.size()) {
    const std::size_t count = std::min(keys.size(), points_m.size() - first);
    cell_keys(points_m.subspan(first, count), cell_m, std::span(keys).first(count));
    for (std::size_t i = 0; i < count; ++i) {
      if (!within_m.contains(points_m[first + i].head<2>())) continue;
      if (last != keys[i]) is_last_inside = cells.contains(keys[i]) ? 1 : 0;
      last = keys[i];
      is_inside[first + i] = is_last_inside;
    }
  }
  return is_inside;
}

}  // namespace

std::optional<Digest> content_of_scans(const ScanStore& store, std::span<const PlacedScan> scans,
                                       ByteWriter before) {
  before.put<std::uint8_t>(store.has_origins() ? 1 : 0);
  for (const PlacedScan& scan : scans) {
    const std::optional<Digest> identity = store.identity(scan.index);
    if (!identity) return std::nullopt;
    before.put_array(std::span<const std::uint8_t>(*identity));
    encode(scan.T_map_lidar, before);
    before.put(scan.min_range_m);
    before.put(scan.max_range_m);
    before.put(scan.part);
  }
  return sha256(before.bytes());
}

std::optional<Digest> content_of_parts(const SurfacePoints& points,
                                       std::span<const std::size_t> parts, ByteWriter before) {
  return content_of_parts(points, parts, reach_of_m(points, parts), std::move(before));
}

std::optional<Digest> content_of_parts(const SurfacePoints& points,
                                       std::span<const std::size_t> parts,
                                       const Eigen::AlignedBox2d& within_m, ByteWriter before) {
  std::vector<PlacedScan> scans;
  for (const std::size_t part : parts) {
    if (part >= points.scans.size()) return std::nullopt;  // lies in memory
    scans.push_back(points.scans[part]);
  }
  // A voxel that is within in part has its centre within or this near.
  before.put(points.voxel_m);
  before.put_array(moved_voxels_within(points, widened_m(within_m, points.voxel_m)));
  if (scans.empty()) return sha256(before.bytes());
  return content_of_scans(*points.store, scans, std::move(before));
}

Result<void> validate(const SurfacePoints& points) {
  if (!points.frame.origin_world_m.allFinite() || !std::isfinite(points.voxel_m) ||
      points.voxel_m < 0.0) {
    return invalid_artifact("the surface points' origin or voxel size is out of range", "");
  }
  for (std::size_t i = 0; i < points.points_m.size(); ++i) {
    if (points.points_m[i].allFinite()) continue;
    return invalid_artifact("found a point that is not finite", concat("standing point ", i));
  }
  for (std::size_t i = 0; i < points.scans.size(); ++i) {
    const std::string place = concat("scan ", i);
    SIGHTLINE_TRY(validate(points.scans[i], place));
    if (i > 0 && points.scans[i].index <= points.scans[i - 1].index) {
      return invalid_artifact("its index is not after that of the scan before it", place);
    }
  }
  for (std::size_t i = 1; i < points.moved_voxels.size(); ++i) {
    if (points.moved_voxels[i - 1] < points.moved_voxels[i]) continue;
    return invalid_artifact("the voxels that moved are not in order", concat("voxel ", i));
  }
  return {};
}

Table dump(const SurfacePoints& points) {
  Table table{"surface-points", {}, {}, {}};
  append_facts(points.frame, table);
  const auto add_count = [&](const char* name, std::uint64_t count) {
    table.facts.emplace_back(name, static_cast<std::int64_t>(count));
  };
  add_count("scan_count", points.scans.size());
  add_count("standing_count", points.standing_count + points.points_m.size());
  add_count("moving_count", points.moving_count);
  add_count("out_of_range_count", points.out_of_range_count);
  table.facts.emplace_back("voxel_m", points.voxel_m);
  table.columns = {"x_m", "y_m", "z_m", "is_moving"};
  for (const Eigen::Vector3d& point : points.points_m) {
    table.rows.push_back({point.x(), point.y(), point.z(), std::int64_t{0}});
  }
  for (const CellKey& key : points.moved_voxels) {
    const Eigen::Vector3d centre_m = cell_centre_m(key, points.voxel_m);
    table.rows.push_back({centre_m.x(), centre_m.y(), centre_m.z(), std::int64_t{1}});
  }
  return table;
}

void reattach(SurfacePoints& points, const Drive& drive, const Trajectory& /*trajectory*/) {
  points.store = drive.store;
}

SurfacePointReader::SurfacePointReader(const SurfacePoints& points)
    : points_(points), within_m_(whole_plane_m()), moved_(points.moved_voxels) {
  SIGHTLINE_CHECK(points.scans.empty() || points.store != nullptr);
}

SurfacePointReader::SurfacePointReader(const SurfacePoints& points,
                                       std::span<const std::size_t> parts)
    : SurfacePointReader(points, parts, whole_plane_m()) {}

SurfacePointReader::SurfacePointReader(const SurfacePoints& points,
                                       std::span<const std::size_t> parts,
                                       const Eigen::AlignedBox2d& within_m)
    : points_(points),
      within_m_(widened_m(within_m, kSlack_m)),
      moved_(moved_voxels_within(
          points, reach_of_m(points, parts).intersection(widened_m(within_m_, points.voxel_m)))) {
  SIGHTLINE_CHECK(points.scans.empty() || points.store != nullptr);
}

std::size_t SurfacePointReader::part_count() const {
  return points_.scans.size() + (points_.points_m.empty() ? 0 : 1);
}

Result<ReturnsInMap> SurfacePointReader::all(std::size_t part) const {
  SIGHTLINE_CHECK(part < part_count());
  if (part == points_.scans.size()) return ReturnsInMap{points_.points_m, {}};
  const PlacedScan& placed = points_.scans[part];
  SIGHTLINE_ASSIGN(const Scan scan, points_.store->read(placed.index));
  ReturnsInMap returns;
  returns.points_m.reserve(scan.points_m.size());
  const SureRange sure_of(placed);
  for (const Eigen::Vector3d& point_lidar_m : scan.points_m) {
    if (!sure_of.holds(point_lidar_m) && !is_within_range(placed, point_lidar_m)) continue;
    returns.points_m.push_back(placed.T_map_lidar * point_lidar_m);
  }
  if (!moved_.empty()) {
    returns.has_moved = which_lie_in(moved_, points_.voxel_m, returns.points_m, within_m_);
  }
  return returns;
}

Result<std::vector<Eigen::Vector3d>> SurfacePointReader::standing(std::size_t part) const {
  SIGHTLINE_ASSIGN(ReturnsInMap returns, all(part));
  return chosen_m(std::move(returns), 0);
}

Result<std::vector<Eigen::Vector3d>> SurfacePointReader::moving(std::size_t part) const {
  SIGHTLINE_ASSIGN(ReturnsInMap returns, all(part));
  return chosen_m(std::move(returns), 1);
}

std::vector<Eigen::Vector3d> SurfacePointReader::chosen_m(ReturnsInMap returns,
                                                          std::uint8_t has_moved) const {
  const bool none_moved = returns.has_moved.empty();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < returns.points_m.size(); ++i) {
    const bool is_chosen = (none_moved ? 0 : returns.has_moved[i]) == has_moved &&
                           within_m_.contains(returns.points_m[i].head<2>());
    returns.points_m[kept] = returns.points_m[i];
    kept += is_chosen ? 1 : 0;
  }
  returns.points_m.resize(kept);
  return std::move(returns.points_m);
}

}  // namespace sightline
