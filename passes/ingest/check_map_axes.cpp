#include "passes/ingest/check_map_axes.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "formats/grid/cell_index.h"
#include "formats/symmetric_eigen.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

constexpr const char* kPlace = "pass ingest-map";
constexpr std::size_t kMostPoints = 2'000'000;

using Points = std::vector<Eigen::Vector3d>;

Result<Points> some_of(const SurfacePoints& points) {
  const SurfacePointReader reader(points);
  Points some;
  for (std::size_t part = 0; part < reader.part_count() && some.size() < kMostPoints; ++part) {
    SIGHTLINE_ASSIGN(const Points standing, reader.standing(part));
    some.insert(some.end(), standing.begin(), standing.end());
  }
  if (some.size() > kMostPoints) some.resize(kMostPoints);
  return some;
}

double points_per_cell(const Points& points, double cell) {
  CellIndex cells;
  for (const Eigen::Vector3d& point : points) cells.add(cell_key(point, cell));
  const std::size_t count = std::max<std::size_t>(1, cells.size());
  return static_cast<double>(points.size()) / static_cast<double>(count);
}

struct HeightColumn {
  std::uint32_t count = 0;
  double lowest = 0.0;
  double highest = 0.0;
};

// Of 99 % of the columns of this width with points enough: 0 where there are none.
double height_of_things(const Points& points, double width) {
  constexpr std::uint32_t kFewestPoints = 10;
  constexpr double kShare = 0.99;
  CellTable<HeightColumn> columns;
  for (const Eigen::Vector3d& point : points) {
    CellKey key = cell_key(point, width);
    key.z = 0;
    const std::uint32_t number = columns.insert(key).number;
    HeightColumn& column = columns.values()[number];
    column.lowest = column.count == 0 ? point.z() : std::min(column.lowest, point.z());
    column.highest = column.count == 0 ? point.z() : std::max(column.highest, point.z());
    ++column.count;
  }
  std::vector<double> heights;
  for (const HeightColumn& column : columns.values()) {
    if (column.count >= kFewestPoints) heights.push_back(column.highest - column.lowest);
  }
  if (heights.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(kShare * static_cast<double>(heights.size() - 1));
  std::ranges::nth_element(heights, heights.begin() + at);
  return heights[static_cast<std::size_t>(at)];
}

// Nothing on a road is 300 m high.
Result<void> check_unit(const Points& points) {
  constexpr double kFewPoints = 1.5;  // per cell of 1
  constexpr double kHighest = 300.0;
  constexpr double kHighestInCentimetres = 3000.0;
  constexpr double kEnoughPoints = 3.0;
  constexpr double kWidest = 1e5;
  constexpr double kColumnInCells = 4.0;
  if (points_per_cell(points, 1.0) >= kFewPoints) return {};
  double cell = 2.0;
  while (cell < kWidest && points_per_cell(points, cell) < kEnoughPoints) cell *= 2.0;
  const double height = height_of_things(points, kColumnInCells * cell);
  if (height <= kHighest) return {};
  const bool are_millimetres = height > kHighestInCentimetres;
  return Error{ErrorCode::kUnsupportedFormat,
               concat("expected a map in metres, but walls and poles in it are up to ",
                      fixed(height, 0), " high and neighbouring points are about ",
                      fixed(0.5 * cell, 0), " apart: these look like ",
                      are_millimetres ? "millimetres" : "centimetres", ". Scale the map to metres"),
               "", kPlace};
}

struct PlanarCell {
  double count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
};

// The axis that a planar cell faces; nothing where it is not planar or faces between two axes.
int axis_of(const PlanarCell& cell) {
  constexpr double kFewestPoints = 8.0;
  constexpr double kFlat = 0.1;     // of the smallest eigenvalue in the middle one
  constexpr double kFacing = 0.95;  // cosine, 18 degrees
  if (cell.count < kFewestPoints) return -1;
  const Eigen::Vector3d mean = cell.sum / cell.count;
  const Eigen::Matrix3d covariance = cell.products / cell.count - mean * mean.transpose();
  const SymmetricEigen<3> found = symmetric_eigen(covariance);
  if (found.values[0] > kFlat * found.values[1]) return -1;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(found.vectors(axis, 0)) > kFacing) return axis;
  }
  return -1;
}

std::int32_t& along(CellKey& key, int axis) {
  return axis == 0 ? key.x : axis == 1 ? key.y : key.z;
}

// 1 where points are only above a cell (along the axis), -1 only below, else 0.
int side_of_points(const CellTable<PlanarCell>& cells, const CellKey& at, int axis) {
  constexpr int kLevels = 3;
  constexpr int kAside = 2;
  std::array<bool, 2> has = {false, false};
  for (int level = 1; level <= kLevels; ++level) {
    for (int u = -kAside; u <= kAside; ++u) {
      for (int v = -kAside; v <= kAside; ++v) {
        for (const int side : {0, 1}) {
          CellKey key = at;
          along(key, (axis + 1) % 3) += u;
          along(key, (axis + 2) % 3) += v;
          along(key, axis) += side == 0 ? -level : level;
          has[static_cast<std::size_t>(side)] |= cells.number_of(key) != CellIndex::kNone;
        }
      }
    }
  }
  return (has[1] ? 1 : 0) - (has[0] ? 1 : 0);
}

// Planar cells that face an axis and have points on one side alone, and the sum of these sides.
struct Facing {
  double cells = 0.0;
  double sides = 0.0;

  // As ground is: many, and with points on the same side.
  [[nodiscard]] bool is_ground() const {
    constexpr double kFewest = 50.0;
    constexpr double kOneSided = 0.6;
    return cells >= kFewest && std::abs(sides) > kOneSided * cells;
  }
};

std::array<Facing, 3> facings(const Points& points) {
  constexpr double kCell_m = 2.0;
  CellTable<PlanarCell> cells;
  for (const Eigen::Vector3d& point : points) {
    const CellKey key = cell_key(point, kCell_m);
    const std::uint32_t number = cells.insert(key).number;
    PlanarCell& cell = cells.values()[number];
    const Eigen::Vector3d within = point - kCell_m * Eigen::Vector3d(key.x, key.y, key.z);
    cell.count += 1.0;
    cell.sum += within;
    cell.products += within * within.transpose();
  }
  std::array<Facing, 3> found;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int axis = axis_of(cells.values()[i]);
    if (axis < 0) continue;
    const int side = side_of_points(cells, cells.keys()[i], axis);
    Facing& facing = found[static_cast<std::size_t>(axis)];
    facing.cells += std::abs(side);
    facing.sides += side;
  }
  return found;
}

Result<void> check_axes(const Points& points) {
  constexpr double kClear = 3.0;  // times as much ground as along z
  constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  const std::array<Facing, 3> found = facings(points);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Facing& facing = found[axis];
    const bool is_other =
        axis < 2 && std::abs(facing.sides) > kClear * std::max(0.0, found[2].sides);
    const bool is_turned = axis == 2 && facing.sides < 0.0;
    if (!facing.is_ground() || !(is_other || is_turned)) continue;
    return Error{
        ErrorCode::kUnsupportedFormat,
        concat("expected a map with z up, but the ground of this one faces ",
               facing.sides < 0.0 ? "-" : "", kNames[axis], " (", fixed(facing.cells, 0),
               " planar cells of 2 m with points on this side only). Rotate the map so that z "
               "points up"),
        "", kPlace};
  }
  return {};
}

}  // namespace

Result<void> check_map_axes(const SurfacePoints& points) {
  SIGHTLINE_ASSIGN(const Points some, some_of(points));
  SIGHTLINE_TRY(check_unit(some));
  return check_axes(some);
}

}  // namespace sightline
