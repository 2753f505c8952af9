#include "compiler/views/exports/voxel_evidence.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace sightline {
namespace {

constexpr int kBlockShift = 2;  // 4 voxels
constexpr int kTileShift = 4;   // 16 blocks
constexpr double kTile_voxels = 1 << (kBlockShift + kTileShift);

TileKey tile_of_block(const CellKey& block) {
  return {block.x >> kTileShift, block.y >> kTileShift};
}

// From a voxel to the tile [low, low + kTile_voxels) along one axis; 0 within.
double distance_voxels(std::int32_t voxel, std::int32_t tile) {
  const double low = tile * kTile_voxels;
  return std::max({low - voxel - 1.0, voxel - low - kTile_voxels, 0.0});
}

}  // namespace

CellKey voxel_block(const CellKey& voxel) {
  return {voxel.x >> kBlockShift, voxel.y >> kBlockShift, voxel.z >> kBlockShift};
}

int child_of_parent(const CellKey& cell) {
  return (cell.x & 1) | (cell.y & 1) << 1 | (cell.z & 1) << 2;
}

int voxel_bit(const CellKey& voxel) {
  return 8 * child_of_parent({voxel.x >> 1, voxel.y >> 1, voxel.z >> 1}) + child_of_parent(voxel);
}

VoxelEvidence::VoxelEvidence(std::vector<CellKey> origins, double reach_voxels,
                             const RayModel& model)
    : origins_(std::move(origins)), reach_voxels_(reach_voxels), model_(model) {}

void VoxelEvidence::add(const ScanBlocks& scan) {
  TileKey key;
  Tile* tile = nullptr;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const CellKey& block = scan.keys()[i];
    if (tile == nullptr || tile_of_block(block) != key) {
      key = tile_of_block(block);
      tile = &tile_of(key);
    }
    constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
    LogOdds unknown;
    unknown.values.fill(kUnknown);
    const std::uint32_t number = tile->insert(block, unknown).number;
    LogOdds& log_odds = tile->values()[number];
    const ScanVoxels& seen = scan.values()[i];
    update(seen.free & ~seen.occupied, model_.miss, log_odds);
    update(seen.occupied, model_.hit, log_odds);
  }
  ++next_scan_;
  retire();
}

void VoxelEvidence::update(std::uint64_t voxels, float by, LogOdds& block) const {
  for (; voxels != 0; voxels &= voxels - 1) {
    float& value = block.values[static_cast<std::size_t>(std::countr_zero(voxels))];
    value = std::clamp((std::isnan(value) ? 0.0F : value) + by, model_.least, model_.most);
  }
}

// The scan being added reaches the tile.
std::size_t VoxelEvidence::last_scan(const TileKey& tile) const {
  for (std::size_t scan = origins_.size(); scan > next_scan_ + 1; --scan) {
    const CellKey& origin = origins_[scan - 1];
    const double x = distance_voxels(origin.x, tile.x);
    const double y = distance_voxels(origin.y, tile.y);
    if (x * x + y * y <= reach_voxels_ * reach_voxels_) return scan - 1;
  }
  return next_scan_;
}

VoxelEvidence::Tile& VoxelEvidence::tile_of(const TileKey& key) {
  std::unique_ptr<Tile>& tile = tiles_[key];
  if (!tile) {
    tile = std::make_unique<Tile>();
    by_last_scan_.emplace(last_scan(key), key);
  }
  return *tile;
}

void VoxelEvidence::retire() {
  while (!by_last_scan_.empty() && by_last_scan_.begin()->first < next_scan_) {
    const auto done = tiles_.extract(by_last_scan_.begin()->second);
    by_last_scan_.erase(by_last_scan_.begin());
    conclude(*done.mapped());
  }
}

void VoxelEvidence::conclude(const Tile& tile) {
  for (std::size_t i = 0; i < tile.size(); ++i) {
    SeenBlock block{tile.keys()[i]};
    for (std::size_t voxel = 0; voxel < 64; ++voxel) {
      const float value = tile.values()[i].values[voxel];
      block.known |= std::uint64_t{!std::isnan(value)} << voxel;
      block.occupied |= std::uint64_t{value >= model_.threshold} << voxel;
    }
    seen_.push_back(block);
  }
}

std::vector<SeenBlock> VoxelEvidence::take() { return std::move(seen_); }

}  // namespace sightline
