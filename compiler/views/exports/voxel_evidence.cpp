#include "compiler/views/exports/voxel_evidence.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace sightline {
namespace {

constexpr int kTileShift = 2;  // 4 chunks
constexpr double kTile_voxels = 64.0;

TileKey tile_of_chunk(const CellKey& chunk) {
  return {chunk.x >> kTileShift, chunk.y >> kTileShift};
}

// From a voxel to the tile [low, low + kTile_voxels) along one axis; 0 within.
double distance_voxels(std::int32_t voxel, std::int32_t tile) {
  const double low = tile * kTile_voxels;
  return std::max({low - voxel - 1.0, voxel - low - kTile_voxels, 0.0});
}

}  // namespace

VoxelEvidence::VoxelEvidence(std::vector<CellKey> origins, double reach_voxels,
                             const RayModel& model)
    : origins_(std::move(origins)), reach_voxels_(reach_voxels), model_(model) {}

void VoxelEvidence::add(const ScanBlocks& scan) {
  for (const ChunkVoxels& chunk : scan.chunks()) add(chunk, tile_of(tile_of_chunk(chunk.key)));
  ++next_scan_;
  retire();
}

void VoxelEvidence::add(const ChunkVoxels& chunk, Tile& tile) const {
  const std::uint32_t inserted = tile.numbers.insert(chunk.key).number;
  std::array<std::uint32_t, kBlocksOfChunk>& numbers = tile.numbers.values()[inserted];
  for (std::size_t i = 0; i < kBlocksOfChunk; ++i) {
    const ScanVoxels& seen = chunk.blocks[i];
    if ((seen.free | seen.occupied) == 0) continue;
    if (numbers[i] == 0) {
      tile.blocks.emplace_back();
      numbers[i] = static_cast<std::uint32_t>(tile.blocks.size());
    }
    update(seen, tile.blocks[numbers[i] - 1]);
  }
}

void VoxelEvidence::update(const ScanVoxels& seen, Block& block) const {
  block.known |= seen.free | seen.occupied;
  std::uint64_t voxels = (seen.free & ~block.least) | seen.occupied;
  for (; voxels != 0; voxels &= voxels - 1) {
    const std::uint64_t bit = voxels & (~voxels + 1);
    float& value = block.log_odds[static_cast<std::size_t>(std::countr_zero(voxels))];
    const float by = (seen.occupied & bit) != 0 ? model_.hit : model_.miss;
    value = std::clamp(value + by, model_.least, model_.most);
    block.least = value > model_.least ? block.least & ~bit : block.least | bit;
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
  for (std::size_t chunk = 0; chunk < tile.numbers.size(); ++chunk) {
    for (std::size_t i = 0; i < kBlocksOfChunk; ++i) {
      const std::uint32_t number = tile.numbers.values()[chunk][i];
      if (number == 0) continue;
      const Block& block = tile.blocks[number - 1];
      SeenBlock seen{block_of_chunk(tile.numbers.keys()[chunk], i), block.known};
      for (std::size_t voxel = 0; voxel < 64; ++voxel) {
        const bool is_occupied = block.log_odds[voxel] >= model_.threshold;
        seen.occupied |= std::uint64_t{is_occupied} << voxel & block.known;
      }
      seen_.push_back(seen);
    }
  }
}

std::vector<SeenBlock> VoxelEvidence::take() { return std::move(seen_); }

}  // namespace sightline
