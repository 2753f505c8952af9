#include "passes/trajectory/local/scan_overlap.h"

#include <algorithm>

namespace sightline {
namespace {

// Columns with returns above each other, and the least height between these. A kerb is lower, and a
// road that climbs by half rises less in a column.
constexpr double kColumn_m = 0.5;
constexpr double kLeastHeight_m = 0.4;
// Beyond, rings are metres apart and one degree of heading is more than what counts as near.
constexpr double kReach_m = 40.0;
// Fewer do not identify a place.
constexpr std::size_t kLeastPoints = 30;
// A point is near another when their cells touch in the plane: 0.15 m at least, 0.3 m on average.
// In height cells are as long as the rings of sparse sensors are apart.
constexpr double kCell_m = 0.15;
constexpr double kLayer_m = 0.5;
// Empty cells are removed when so many are in use.
constexpr std::size_t kMostCells = 2'000'000;

struct Span {
  double low_m = 0.0;
  double high_m = 0.0;
};

CellKey column_of(const Eigen::Vector3d& point_m) {
  return {floor_to_int(point_m.x() / kColumn_m), floor_to_int(point_m.y() / kColumn_m), 0};
}

CellKey cell_of(const Eigen::Vector3d& point_m) {
  return {floor_to_int(point_m.x() / kCell_m), floor_to_int(point_m.y() / kCell_m),
          floor_to_int(point_m.z() / kLayer_m)};
}

}  // namespace

std::vector<Eigen::Vector3d> upright_points(const std::vector<Eigen::Vector3d>& points_m,
                                            const Eigen::Matrix3d& level) {
  CellTable<Span> columns;
  std::vector<std::uint32_t> near;  // of points_m
  std::vector<std::uint32_t> column_of_near;
  for (std::uint32_t i = 0; i < points_m.size(); ++i) {
    if (points_m[i].norm() > kReach_m) continue;
    const Eigen::Vector3d levelled_m = level * points_m[i];
    const double z_m = levelled_m.z();
    const std::uint32_t number = columns.insert(column_of(levelled_m), {z_m, z_m}).number;
    Span& span = columns.values()[number];
    span = {std::min(span.low_m, z_m), std::max(span.high_m, z_m)};
    near.push_back(i);
    column_of_near.push_back(number);
  }
  std::vector<Eigen::Vector3d> upright_m;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const Span& span = columns.values()[column_of_near[i]];
    if (span.high_m - span.low_m >= kLeastHeight_m) upright_m.push_back(points_m[near[i]]);
  }
  return upright_m;
}

void UprightMap::count(const std::vector<Eigen::Vector3d>& points_m) {
  for (const Eigen::Vector3d& point_m : points_m) {
    const std::uint32_t number = counts_.insert(cell_of(point_m), 0).number;
    ++counts_.values()[number];
  }
}

void UprightMap::add(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar,
                     double driven_m) {
  KeyScan& key = scans_.emplace_back();
  key.driven_m = driven_m;
  key.points_m.reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) key.points_m.push_back(T_map_lidar * point_m);
  count(key.points_m);
  while (scans_.front().driven_m < driven_m - reach_m_) {
    for (const Eigen::Vector3d& point_m : scans_.front().points_m) {
      --*counts_.find(cell_of(point_m));
    }
    scans_.pop_front();
  }
  if (counts_.size() < kMostCells) return;
  counts_.clear();
  for (const KeyScan& scan : scans_) count(scan.points_m);
}

bool UprightMap::has_near(const Eigen::Vector3d& point_m) const {
  const CellKey middle = cell_of(point_m);
  // The likeliest first: the same height, then nearer to farther.
  static constexpr std::int32_t kOrder[] = {0, -1, 1};
  static constexpr std::int32_t kAcross[] = {0, -1, 1};
  for (const std::int32_t z : kOrder) {
    for (const std::int32_t x : kAcross) {
      for (const std::int32_t y : kAcross) {
        const std::int32_t* count = counts_.find({middle.x + x, middle.y + y, middle.z + z});
        if (count != nullptr && *count > 0) return true;
      }
    }
  }
  return false;
}

std::optional<double> UprightMap::overlap(const std::vector<Eigen::Vector3d>& points_m,
                                          const Pose& T_map_lidar) const {
  if (points_m.size() < kLeastPoints || counts_.empty()) return std::nullopt;
  const auto near = std::ranges::count_if(
      points_m, [&](const Eigen::Vector3d& point_m) { return has_near(T_map_lidar * point_m); });
  return static_cast<double>(near) / static_cast<double>(points_m.size());
}

std::vector<Eigen::Vector3d> UprightMap::points_m() const {
  std::vector<Eigen::Vector3d> all_m;
  for (const KeyScan& scan : scans_) {
    all_m.insert(all_m.end(), scan.points_m.begin(), scan.points_m.end());
  }
  return all_m;
}

}  // namespace sightline
