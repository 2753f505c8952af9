#include "passes/map/places/ground_floors.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "passes/map/surface/ground_gaps.h"

namespace sightline {
namespace {

constexpr double kColumn_m = GroundFloors::kColumn_m;
constexpr int kColumnsAround = 1;  // the square of 3 m is the column of a place and its neighbours
constexpr double kSteepestGround = 0.9;    // height of its normal: 25 degrees
constexpr int kLeastSquares = 8;           // a patch with fewer solid ones is a shard
constexpr double kStep_m = 0.5;            // heights farther apart are two levels
constexpr double kHeadroom_m = 2.5;        // from one floor to the next
constexpr std::size_t kLeastOfLowest = 4;  // columns of the nine that a level must have
constexpr std::size_t kLeastOfUpper = 5;

struct Seen {
  double height_m = 0.0;  // at the place that was asked about
  std::size_t column = 0;
};

// The level that begins at seen[first]; `end` is one past its last.
struct Cluster {
  std::size_t end = 0;
  std::size_t column_count = 0;
  double height_m = 0.0;  // median
};

Cluster cluster_from(const std::vector<Seen>& seen, std::size_t first) {
  Cluster cluster;
  std::uint32_t columns = 0;
  for (cluster.end = first; cluster.end < seen.size(); ++cluster.end) {
    const bool is_apart = cluster.end > first &&
                          seen[cluster.end].height_m - seen[cluster.end - 1].height_m > kStep_m;
    if (is_apart) break;
    columns |= 1U << seen[cluster.end].column;
  }
  cluster.column_count = static_cast<std::size_t>(std::popcount(columns));
  cluster.height_m = seen[(first + cluster.end) / 2].height_m;
  return cluster;
}

CellKey column_of(const Eigen::Vector3d& place_m) {
  return cell_key({place_m.x(), place_m.y(), 0.0}, kColumn_m);
}

// Those that the middle of a solid square lies in, ascending.
std::vector<CellKey> columns_under(const SurfacePatch& patch) {
  std::vector<CellKey> columns;
  visit_solid_squares(patch, /*parts=*/1, [&](const Eigen::Vector3d& middle_m) {
    columns.push_back(column_of(middle_m));
  });
  std::ranges::sort(columns);
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  return columns;
}

}  // namespace

void GroundFloors::add(const Surface& surface) {
  const bool is_wide = surface.cell_m > kColumn_m;
  for (const SurfacePatch& patch : surface.patches) {
    if (patch.normal.z() < kSteepestGround || std::popcount(patch.solid) < kLeastSquares) continue;
    const std::vector<CellKey> columns =
        is_wide ? columns_under(patch) : std::vector{column_of(patch.centre_m)};
    for (const CellKey& column : columns) {
      const auto [number, is_new] = columns_.insert(column);
      columns_.values()[number].push_back(
          {patch.centre_m.z(), patch.centre_m.head<2>(), -patch.normal.x() / patch.normal.z(),
           -patch.normal.y() / patch.normal.z(), !is_ground_between(patch, surface)});
    }
  }
}

Result<GroundFloors> floors_of(const TiledSurface& surface) {
  GroundFloors floors;
  for (const RowTile& place : surface.tiles()) {
    SIGHTLINE_ASSIGN(const Surface tile, surface.tile(place));
    floors.add(tile);
  }
  return floors;
}

bool GroundFloors::is_seen(const Eigen::Vector2d& place_map_m, double height_m) const {
  const std::vector<Level>* levels =
      columns_.find(column_of({place_map_m.x(), place_map_m.y(), 0.0}));
  return levels != nullptr && std::ranges::any_of(*levels, [&](const Level& level) {
           return level.is_seen && std::abs(level.height_m - height_m) <= kStep_m;
         });
}

template <class Use>
void GroundFloors::visit_around(const Eigen::Vector2d& place_map_m, const Use& use) const {
  const CellKey middle = column_of({place_map_m.x(), place_map_m.y(), 0.0});
  std::size_t column = 0;
  for (int dx = -kColumnsAround; dx <= kColumnsAround; ++dx) {
    for (int dy = -kColumnsAround; dy <= kColumnsAround; ++dy, ++column) {
      const std::vector<Level>* levels = columns_.find({middle.x + dx, middle.y + dy, 0});
      if (levels == nullptr) continue;
      for (const Level& level : *levels) use(level, column);
    }
  }
}

bool GroundFloors::is_seen_around(const Eigen::Vector2d& place_map_m, double height_m) const {
  bool is_there = false;
  visit_around(place_map_m, [&](const Level& level, std::size_t) {
    is_there |= level.is_seen && std::abs(level.height_at_m(place_map_m) - height_m) <= kStep_m;
  });
  return is_there;
}

std::vector<double> GroundFloors::at(const Eigen::Vector2d& place_map_m) const {
  std::vector<Seen> seen;
  visit_around(place_map_m, [&](const Level& level, std::size_t column) {
    seen.push_back({level.height_at_m(place_map_m), column});
  });
  std::ranges::sort(seen, {}, [](const Seen& s) { return std::pair(s.height_m, s.column); });
  std::vector<double> floors_m;
  for (std::size_t first = 0; first < seen.size();) {
    const Cluster cluster = cluster_from(seen, first);
    const std::size_t least = floors_m.empty() ? kLeastOfLowest : kLeastOfUpper;
    const bool is_free = floors_m.empty() || cluster.height_m - floors_m.back() >= kHeadroom_m;
    if (is_free && cluster.column_count >= least) floors_m.push_back(cluster.height_m);
    first = cluster.end;
  }
  return floors_m;
}

}  // namespace sightline
