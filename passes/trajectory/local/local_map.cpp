#include "passes/trajectory/local/local_map.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace sightline {
namespace {

constexpr double kCoarseCell_m = 2.0;
constexpr double kFineCell_m = 1.0;
// Fewer than a map needs, because a local one begins with a single scan.
constexpr double kLeastPoints = 6.0;
// lambda_1 of a valid ND ("NDT map" in schemas/definitions.md, v1).
constexpr double kLeastExtent_m2 = 1e-6;
// Standard deviations across and along the surface of a cell. The thinner a wall, the more accurate
// a match, and the nearer its start must be.
constexpr double kThinnest_m = 0.05;
constexpr double kSharplyThinnest_m = 0.01;
constexpr double kAlong_m = 2.0;
// A scan joins the local map when the vehicle has come this far since the last one that did.
constexpr double kKeyframeStep_m = 1.0;
constexpr double kKeyframeTurn_rad = 0.1;

// A wall constrains a point along its normal; along the wall the points of a cell end where the
// field of view ended. Taken as shape, that end would tilt each scan a little, always in one
// direction.
Eigen::Matrix3d information_per_m2(const Nd& nd, double thinnest_m) {
  Eigen::Vector3d variance_m2 = nd.eigenvalues_m2.cwiseMax(thinnest_m * thinnest_m);
  const double along_m2 = kAlong_m * kAlong_m;
  const int dimensions = dimension_class(nd);
  if (dimensions == 2) {
    variance_m2[0] = variance_m2[1] = along_m2;
  } else if (dimensions == 1) {
    const bool is_upright = std::abs(nd.eigenvectors(2, 0)) > 0.7;
    variance_m2[0] = along_m2;
    // A ring of the sensor is a line as well, but no edge.
    if (!is_upright) variance_m2[1] = variance_m2[2] = along_m2;
  }
  return nd.eigenvectors * variance_m2.cwiseInverse().asDiagonal() * nd.eigenvectors.transpose();
}

std::vector<CellPart> parts_of(const CellTable<CellMoments>& cells) {
  std::vector<CellPart> parts;
  parts.reserve(cells.keys().size());
  for (std::size_t i = 0; i < cells.keys().size(); ++i) {
    parts.push_back({cells.keys()[i], cells.values()[i]});
  }
  return parts;
}

std::vector<CellPart> parts_of(const std::vector<Eigen::Vector3d>& points_m, double cell_m) {
  std::vector<CellKey> keys(points_m.size());
  cell_keys(points_m, cell_m, keys);
  std::vector<CellRun> runs(keys.size());
  runs.resize(find_runs(keys, runs));
  CellTable<CellMoments> cells;
  cells.add(runs, [&](CellMoments& moments, const CellRun& run) {
    const Eigen::Vector3d centre_m = cell_centre_m(run.key, cell_m);
    for (const Eigen::Vector3d& point_m : std::span(points_m).subspan(run.begin, run.count)) {
      moments.add(point_m - centre_m);
    }
  });
  return parts_of(cells);
}

// Eight fine cells are a coarse one.
std::vector<CellPart> coarse_parts(const std::vector<CellPart>& fine) {
  static_assert(kCoarseCell_m == 2.0 * kFineCell_m);
  std::vector<CellRun> runs;
  runs.reserve(fine.size());
  for (std::uint32_t i = 0; i < fine.size(); ++i) {
    const CellKey& key = fine[i].key;
    runs.push_back({{key.x >> 1, key.y >> 1, key.z >> 1}, i, 1});
  }
  CellTable<CellMoments> cells;
  cells.add(runs, [&](CellMoments& moments, const CellRun& run) {
    const CellPart& part = fine[run.begin];
    moments.add(part.moments.seen_from(cell_centre_m(part.key, kFineCell_m) -
                                       cell_centre_m(run.key, kCoarseCell_m)));
  });
  return parts_of(cells);
}

// All points that were added were removed again.
bool is_empty(const CellMoments& moments) { return !(moments.count > 0.5); }

// A lorry that is passed slowly fills a cell for 3 m of way.
constexpr double kLasting_m = 5.0;

// Columns with returns above each other, and the least height between these. A kerb is lower, and a
// road that climbs by half rises less in a column.
constexpr double kColumn_m = 0.5;
constexpr double kLeastHeight_m = 0.4;
// Beyond, rings are metres apart and one degree of heading is more than what counts as near.
constexpr double kReach_m = 40.0;
// Fewer do not identify a place.
constexpr std::size_t kLeastUprightPoints = 30;
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

Eigen::Matrix3d surface_information_per_m2(const Nd& nd) {
  return information_per_m2(nd, kThinnest_m);
}

void RollingCells::add(const std::vector<CellPart>& parts, double sign, double way_m) {
  if (sign > 0.0) {
    if (cells_.empty()) first_m_ = way_m;
    last_m_ = way_m;
  }
  for (const CellPart& part : parts) {
    const std::uint32_t number = index_.add(part.key);
    if (number == cells_.size()) cells_.emplace_back().key = part.key;
    Cell& cell = cells_[number];
    if (sign > 0.0) {
      if (is_empty(cell.moments)) cell.first_m = way_m;
      cell.last_m = way_m;
    }
    cell.moments.add(part.moments, sign);
    cell.is_changed = true;
  }
}

void RollingCells::finish() {
  std::vector<std::size_t> full;  // of the cells that changed
  std::vector<Nd> nds;
  std::size_t empty_count = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    if (is_empty(cell.moments)) {
      cell.moments = {};  // without the rounding errors of adding and removing
      ++empty_count;
    }
    if (!std::exchange(cell.is_changed, false)) continue;
    cell.is_valid = false;
    if (cell.moments.count < kLeastPoints) {
      if (has_grid_) grid_.take_away(cell.key);
      continue;
    }
    full.push_back(i);
    nds.push_back(undecomposed_nd(cell.key, cell.moments, cell_m_));
  }
  decompose(nds);
  for (std::size_t i = 0; i < full.size(); ++i) {
    Cell& cell = cells_[full[i]];
    cell.nd = nds[i];
    cell.is_valid = cell.nd.eigenvalues_m2[0] >= kLeastExtent_m2;
    if (!cell.is_valid && has_grid_) grid_.take_away(cell.key);
  }
  if (has_grid_) {
    std::erase_if(nds, [](const Nd& nd) { return nd.eigenvalues_m2[0] < kLeastExtent_m2; });
    grid_.put(nds, surface_information_per_m2);
    grid_.finish();
  }
  // Renumbering all cells takes longer than skipping a few empty ones.
  if (4 * empty_count <= cells_.size()) return;
  std::erase_if(cells_, [](const Cell& cell) { return is_empty(cell.moments); });
  index_ = CellIndex();
  for (const Cell& cell : cells_) index_.add(cell.key);
}

NdtMap RollingCells::nds() const {
  NdtMap map;
  map.cell_m = cell_m_;
  for (const Cell& cell : cells_) {
    if (cell.is_valid) map.nds.push_back(cell.nd);
  }
  return map;
}

const Nd* RollingCells::nd(const CellKey& key) const {
  const std::uint32_t number = index_.find(key);
  if (number == CellIndex::kNone || !cells_[number].is_valid) return nullptr;
  return &cells_[number].nd;
}

bool RollingCells::is_lasting(const CellKey& key) const {
  const std::uint32_t number = index_.find(key);
  if (number == CellIndex::kNone) return false;
  const Cell& cell = cells_[number];
  return cell.last_m - cell.first_m >= std::min(kLasting_m, 0.5 * (last_m_ - first_m_));
}

LocalGrids::LocalGrids() : coarse_(kCoarseCell_m), fine_(kFineCell_m) { finish(); }

GriddedPoints gridded(const std::vector<Eigen::Vector3d>& points_m) {
  GriddedPoints points;
  points.fine = parts_of(points_m, kFineCell_m);
  points.coarse = coarse_parts(points.fine);
  return points;
}

void LocalGrids::add(const GriddedPoints& points, double sign, double way_m) {
  coarse_.add(points.coarse, sign, way_m);
  fine_.add(points.fine, sign, way_m);
}

void LocalGrids::finish() {
  coarse_.finish();
  fine_.finish();
  sharp_ = std::make_shared<Sharp>();
}

const MatchGrid& LocalGrids::sharp() const {
  std::call_once(sharp_->once, [this] {
    sharp_->grid = make_match_grid(
        fine_.nds(), [](const Nd& nd) { return information_per_m2(nd, kSharplyThinnest_m); });
  });
  return sharp_->grid;
}

LocalGrids local_grids(const std::vector<Eigen::Vector3d>& points_m) {
  LocalGrids grids;
  grids.add(gridded(points_m), 1.0);
  grids.finish();
  return grids;
}

bool is_key_step(const Pose& T_map_last, const Pose& T_map_lidar) {
  const Pose step = T_map_last.inverse() * T_map_lidar;
  return step.translation().norm() >= kKeyframeStep_m ||
         rotation_angle_rad(step.linear()) >= kKeyframeTurn_rad;
}

void LocalMap::add(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar,
                   double driven_m) {
  std::vector<Eigen::Vector3d> points_map_m;
  points_map_m.reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) points_map_m.push_back(T_map_lidar * point_m);
  scans_.push_back({driven_m, gridded(points_map_m), {}});
  scans_.back().points_map_m = std::move(points_map_m);
  grids_.add(scans_.back().points, 1.0, driven_m);
  while (scans_.front().driven_m < driven_m - reach_m_) {
    grids_.add(scans_.front().points, -1.0);
    scans_.pop_front();
  }
  grids_.finish();
  T_map_last_ = T_map_lidar;
}

const RollingCells& LocalMap::details() const {
  auto& [cells, parts] = details_;
  const double first_m = scans_.front().driven_m;
  bool is_changed = false;
  for (; !parts.empty() && parts.front().first < first_m; parts.pop_front()) {
    cells.add(parts.front().second, -1.0, parts.front().first);
    is_changed = true;
  }
  for (const KeyScan& scan : scans_) {
    if (!parts.empty() && scan.driven_m <= parts.back().first) continue;
    parts.emplace_back(scan.driven_m, parts_of(scan.points_map_m, kDetailCell_m));
    cells.add(parts.back().second, 1.0, scan.driven_m);
    is_changed = true;
  }
  if (is_changed) cells.finish();
  return cells;
}

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
  for (const std::int32_t z : kOrder) {
    for (const std::int32_t x : kOrder) {
      for (const std::int32_t y : kOrder) {
        const std::int32_t* count = counts_.find({middle.x + x, middle.y + y, middle.z + z});
        if (count != nullptr && *count > 0) return true;
      }
    }
  }
  return false;
}

std::optional<double> UprightMap::overlap(const std::vector<Eigen::Vector3d>& points_m,
                                          const Pose& T_map_lidar) const {
  if (points_m.size() < kLeastUprightPoints || counts_.empty()) return std::nullopt;
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
