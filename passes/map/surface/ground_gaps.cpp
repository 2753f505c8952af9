#include "passes/map/surface/ground_gaps.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "formats/grid/cell_index.h"

namespace sightline {
namespace {

constexpr double kColumnPerCell = 2.0;   // edge of a column; coarser than what is seen
constexpr double kSteepestGround = 0.9;  // height of its normal: 25 degrees
constexpr int kMostColumns = 16;         // from ground to ground
static_assert(kReachOfGround_cells >= kColumnPerCell * (kMostColumns + 1));
constexpr int kColumnsBeyond = 5;  // where there is ground on one side alone
// Between two ends: unevenness, and the steepest street.
constexpr double kMostStep_m = 0.2;
constexpr double kMostSlope = 0.1;
// A patch with fewer solid squares is a shard of something else.
constexpr int kLeastSquares = 8;

// The lowest level patch over a square of the plane.
struct Column {
  double height_m = std::numeric_limits<double>::infinity();  // in the middle of the column
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};
using Columns = CellTable<Column>;  // keys with z = 0

// What was found between two columns of ground.
struct Bridge {
  double length_m = std::numeric_limits<double>::infinity();
  Column column;
};

// Lower, and of what is as high the one that no order of patches decides.
bool is_before(double height_m, const Eigen::Vector3d& normal, const Column& column) {
  return std::tuple(height_m, normal.x(), normal.y()) <
         std::tuple(column.height_m, column.normal.x(), column.normal.y());
}

CellKey beside(const CellKey& key, const std::array<int, 2>& step, int count) {
  return {key.x + count * step[0], key.y + count * step[1], 0};
}

Columns ground_columns(std::span<const SurfacePatch> patches, double column_m) {
  Columns columns;
  for (const SurfacePatch& patch : patches) {
    if (!is_ground(patch)) continue;
    CellKey key = cell_key(patch.centre_m, column_m);
    key.z = 0;
    const Eigen::Vector3d middle_m = cell_centre_m(key, column_m);
    const Eigen::Vector2d off_m = (middle_m - patch.centre_m).head<2>();
    const double height_m =
        patch.centre_m.z() - patch.normal.head<2>().dot(off_m) / patch.normal.z();
    const std::uint32_t number = columns.insert(key).number;
    Column& column = columns.values()[number];
    if (is_before(height_m, patch.normal, column)) column = {height_m, patch.normal};
  }
  return columns;
}

// Number of steps to the next ground that may be a part of the same; 0 where there is none, or
// nothing is between.
int steps_to_ground(const Columns& columns, const CellKey& from, const std::array<int, 2>& step) {
  for (int count = 1; count <= kMostColumns; ++count) {
    if (columns.find(beside(from, step, count)) != nullptr) return count == 1 ? 0 : count;
  }
  return 0;
}

// Notes what a column may be, if nothing nearer is known.
void note(const CellKey& key, const Bridge& bridge, CellTable<Bridge>& bridges) {
  const std::uint32_t number = bridges.insert(key).number;
  Bridge& best = bridges.values()[number];
  if (bridge.length_m < best.length_m) best = bridge;
}

void bridge(const Columns& columns, std::size_t from, const std::array<int, 2>& step,
            double column_m, CellTable<Bridge>& bridges) {
  const CellKey key = columns.keys()[from];
  const int count = steps_to_ground(columns, key, step);
  if (count == 0) return;
  const Column& near = columns.values()[from];
  const Column& far = *columns.find(beside(key, step, count));
  const double length_m = count * column_m * std::sqrt(step[0] * step[0] + step[1] * step[1]);
  if (length_m > kMostColumns * column_m) return;
  if (std::abs(far.height_m - near.height_m) > kMostStep_m + kMostSlope * length_m) return;
  for (int i = 1; i < count; ++i) {
    const double share = static_cast<double>(i) / count;
    const Column between{(1.0 - share) * near.height_m + share * far.height_m,
                         ((1.0 - share) * near.normal + share * far.normal).normalized()};
    note(beside(key, step, i), {length_m, between}, bridges);
  }
}

// As high as the last that was seen; anything between two ends counts as nearer.
void extend(const Columns& columns, std::size_t from, const std::array<int, 2>& step,
            double column_m, CellTable<Bridge>& bridges) {
  const CellKey key = columns.keys()[from];
  const Column& last = columns.values()[from];
  for (int i = 1; i <= kColumnsBeyond; ++i) {
    if (columns.find(beside(key, step, i)) != nullptr) return;
    const double off_m = i * column_m * std::sqrt(step[0] * step[0] + step[1] * step[1]);
    note(beside(key, step, i), {kMostColumns * column_m + off_m, {last.height_m}}, bridges);
  }
}

}  // namespace

bool is_ground(const SurfacePatch& patch) {
  return patch.normal.z() >= kSteepestGround && std::popcount(patch.solid) >= kLeastSquares;
}

std::vector<SurfacePatch> ground_between(std::span<const SurfacePatch> patches, double cell_m) {
  // Each pair of ends is met once.
  constexpr std::array<std::array<int, 2>, 4> kSteps = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  const double column_m = kColumnPerCell * cell_m;
  const Columns columns = ground_columns(patches, column_m);
  CellTable<Bridge> bridges;
  for (const std::array<int, 2>& step : kSteps) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      bridge(columns, i, step, column_m, bridges);
      extend(columns, i, step, column_m, bridges);
      extend(columns, i, {-step[0], -step[1]}, column_m, bridges);
    }
  }
  std::vector<SurfacePatch> between;
  for (std::size_t i = 0; i < bridges.size(); ++i) {
    const Column& column = bridges.values()[i].column;
    if (!std::isfinite(column.height_m)) continue;
    SurfacePatch patch;
    patch.centre_m = cell_centre_m(bridges.keys()[i], column_m);
    patch.centre_m.z() = column.height_m;
    patch.normal = column.normal;
    patch.half_side_m = 0.5 * column_m;
    patch.key = cell_key(patch.centre_m, cell_m);
    between.push_back(patch);
  }
  return between;
}

}  // namespace sightline
