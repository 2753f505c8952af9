#include "passes/map/asked_voxels.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "formats/grid/cell_blocks.h"
#include "passes/map/moving_verdict.h"

namespace sightline {
namespace {

// A ray passes through a voxel's points when it comes this near their mean, in voxels.
constexpr double kTouch_voxels = 0.5;
// No ray goes on below the ground: one that passes this far below what seems to be ground says that
// it is not. Noise of ranges and poses stays below it.
constexpr double kBelowGround_m = 0.03;
// What ends so far beneath the ground of a voxel near it is a mirror image: its ray did not go
// straight on. Downhill streets stay above that.
constexpr double kNearGround_m = 0.3;
constexpr double kBeneath_m = 1.0;
// Edge of the columns that are near a sensor or not as a whole.
constexpr double kColumn_m = 4.0;

constexpr std::uint32_t kNone = 0xffffffff;

// Adds the voxels that touch one and stand above the ground.
void add_standing_around(const SeenVoxels& seen, const CellWindow& around, const CellKey& key,
                         std::vector<std::uint32_t>& touching) {
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const std::uint32_t near = around.number_of({key.x + x, key.y + y, key.z + z});
        if (near == CellWindow::kNone || seen.values()[near].is_ground) continue;
        touching.push_back(near);
      }
    }
  }
}

}  // namespace

Eigen::AlignedBox2d box_of(const TileKey& key, double edge_m) {
  const Eigen::Vector2d low_m(key.x * edge_m, key.y * edge_m);
  return {low_m, low_m + Eigen::Vector2d::Constant(edge_m)};
}

double AskedVoxels::touch_m(double voxel_m) { return kTouch_voxels * voxel_m; }

void AskedVoxels::Places::add(const Eigen::Vector3d& mean_m, Column& column) {
  const Eigen::Vector3f from_anchor_m = (mean_m - column.anchor_m).cast<float>();
  x_m.push_back(from_anchor_m.x());
  y_m.push_back(from_anchor_m.y());
  z_m.push_back(from_anchor_m.z());
  column.radius_m = std::max(column.radius_m, from_anchor_m.norm());
}

RayPlaces AskedVoxels::Places::of(const Column& column) const {
  const auto some = [&](const std::vector<float>& all) {
    return std::span(all).subspan(column.begin, column.end - column.begin);
  };
  return {column.anchor_m, column.radius_m, some(x_m), some(y_m), some(z_m)};
}

AskedVoxels::AskedVoxels(const LookOptions& options, SeenVoxels& seen, DriveEvidence* of_drives,
                         const ScansNear& scans_near)
    : options_(options), seen_(seen), of_drives_(of_drives), hit_by_(seen.size(), kNone) {
  choose(scans_near);
  gather_neighbours();
}

bool AskedVoxels::stands_anyway_here(std::uint32_t voxel,
                                     const std::vector<std::size_t>& scan_counts) const {
  if (of_drives_ != nullptr) return of_drives_->stands_anyway(voxel, scan_counts);
  return stands_anyway(seen_.values()[voxel],
                       std::accumulate(scan_counts.begin(), scan_counts.end(), std::size_t{0}));
}

void AskedVoxels::choose(const ScansNear& scans_near) {
  std::vector<std::pair<TileKey, std::uint32_t>> order;
  for (std::uint32_t v = 0; v < seen_.size(); ++v) {
    const Eigen::Vector3d at_m = cell_centre_m(seen_.keys()[v], options_.voxel_m) / kColumn_m;
    order.push_back({{floor_to_int(at_m.x()), floor_to_int(at_m.y())}, v});
  }
  std::ranges::sort(order);
  std::vector<std::size_t> scan_counts;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t v = order[i].second;
    const SeenVoxel& voxel = seen_.values()[v];
    if (i == 0 || order[i].first != order[i - 1].first) {
      const auto begin = static_cast<std::uint32_t>(asked_.size());
      columns_.push_back({box_of(order[i].first, kColumn_m), begin, begin, voxel.mean_m()});
      scan_counts = scans_near(columns_.back().box);
    }
    if (stands_anyway_here(v, scan_counts)) continue;
    places_.add(voxel.mean_m(), columns_.back());
    asked_.push_back({voxel.mean_m(), voxel.above_ground_m, voxel.is_ground, v});
    ++columns_.back().end;
  }
}

void AskedVoxels::gather_neighbours() {
  std::vector<std::uint32_t> asked_of(seen_.size(), kNone);
  for (std::uint32_t i = 0; i < asked_.size(); ++i) asked_of[asked_[i].number] = i;
  const CellBlocks blocks(seen_.keys());
  CellWindow around(blocks, {1, 1, 1}, {1, 1, 1});
  for (std::size_t block = 0; block < blocks.size(); ++block) {
    around.move_to(block);
    for (const auto& [key, v] : blocks.cells(block)) {
      if (asked_of[v] == kNone) continue;
      Asked& asked = asked_[asked_of[v]];
      asked.touching_begin = touching_.size();
      add_standing_around(seen_, around, key, touching_);
      asked.touching_end = touching_.size();
    }
  }
}

void AskedVoxels::look(const LookingScan& scan) {
  for (const std::uint32_t v : scan.hit_voxels) hit_by_[v] = scan.number;
  const Eigen::Vector2d origin_m = scan.T_map_lidar.translation().head<2>();
  for (const Column& column : columns_) {
    if (column.box.exteriorDistance(origin_m) > options_.range_m) continue;
    look_into(column, scan);
  }
}

void AskedVoxels::conclude() {
  for (const Asked& voxel : asked_) seen_.values()[voxel.number].misses = voxel.misses;
}

void AskedVoxels::look_into(const Column& column, const LookingScan& scan) {
  constexpr std::size_t kAhead = 4;
  scan.rays.find_passable(places_.of(column), scan.T_map_lidar.inverse(), touch_m(options_.voxel_m),
                          passable_);
  for (std::size_t i = 0; i < passable_.size(); ++i) {
    if (i + kAhead < passable_.size()) {
      __builtin_prefetch(&asked_[column.begin + passable_[i + kAhead]], 1);
    }
    Asked& voxel = asked_[column.begin + passable_[i]];
    if (!looks_through(scan, voxel) || is_spared(voxel, scan.number)) continue;
    ++voxel.misses;
    if (of_drives_ != nullptr) of_drives_->add_miss(voxel.number, scan.part);
  }
}

// A scan does not contradict what it hit, nor what is beside something standing that it hit.
bool AskedVoxels::is_spared(const Asked& voxel, std::uint32_t scan) const {
  if (hit_by_[voxel.number] == scan) return true;
  const auto touching =
      std::span(touching_).subspan(voxel.touching_begin, voxel.touching_end - voxel.touching_begin);
  return std::ranges::any_of(touching, [&](std::uint32_t v) { return hit_by_[v] == scan; });
}

bool AskedVoxels::looks_through(const LookingScan& scan, const Asked& voxel) const {
  const Eigen::Vector3d from_sensor_m = voxel.mean_m - scan.T_map_lidar.translation();
  if (from_sensor_m.squaredNorm() > options_.range_m * options_.range_m) return false;
  RayQuery query;
  query.at_m = scan.T_map_lidar.linear().transpose() * from_sensor_m;
  query.touch_m = touch_m(options_.voxel_m);
  query.up = scan.T_map_lidar.linear().row(2);
  if (voxel.is_ground) query.least_below_m = kBelowGround_m;
  if (voxel.above_ground_m < kNearGround_m) {
    query.lowest_end_m = from_sensor_m.z() - voxel.above_ground_m - kBeneath_m;
  }
  return scan.rays.pass_through(query);
}

}  // namespace sightline
