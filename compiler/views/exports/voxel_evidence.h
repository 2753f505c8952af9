#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "compiler/views/exports/scan_blocks.h"
#include "formats/grid/cell_index.h"

// What rays say of voxels, summed scan by scan as log-odds (Hornung et al. 2013, "OctoMap: an
// efficient probabilistic 3D mapping framework based on octrees", section 3).

namespace sightline {

// The sensor model, in log-odds.
struct RayModel {
  float hit = 0.0F;
  float miss = 0.0F;
  float least = 0.0F;  // limits of their sum
  float most = 0.0F;
  float threshold = 0.0F;  // from here on a voxel is occupied
};

// A block whose evidence is complete.
struct SeenBlock {
  CellKey key;
  std::uint64_t known = 0;
  std::uint64_t occupied = 0;  // of the known
};

// Sums the evidence of scans in their order. It holds the log-odds of only those tiles that a later
// scan may reach: memory follows the sensor's range, not the length of the drive.
class VoxelEvidence {
 public:
  // `origins`: the voxels in which the sensor was, of all scans to come in their order. No ray of a
  // scan ends more than `reach_voxels` from its origin.
  VoxelEvidence(std::vector<CellKey> origins, double reach_voxels, const RayModel& model);

  // The next scan's voxels.
  void add(const ScanBlocks& scan);
  // After the last scan: all blocks with a known voxel, each once.
  std::vector<SeenBlock> take();

 private:
  struct Block {
    std::uint64_t known = 0;
    std::uint64_t least = 0;  // voxels at the lower limit, where a miss changes nothing
    std::array<float, 64> log_odds{};
  };
  // By chunk: 1 and up in `blocks`; 0: not met yet.
  struct Tile {
    CellTable<std::array<std::uint32_t, kBlocksOfChunk>> numbers;
    std::vector<Block> blocks;
  };

  [[nodiscard]] std::size_t last_scan(const TileKey& tile) const;
  Tile& tile_of(const TileKey& key);
  void add(const ChunkVoxels& chunk, Tile& tile) const;
  void update(const ScanVoxels& seen, Block& block) const;
  // Concludes the tiles that no scan from the next one on reaches.
  void retire();
  void conclude(const Tile& tile);

  std::vector<CellKey> origins_;
  double reach_voxels_;
  RayModel model_;
  std::size_t next_scan_ = 0;
  std::map<TileKey, std::unique_ptr<Tile>> tiles_;
  std::multimap<std::size_t, TileKey> by_last_scan_;
  std::vector<SeenBlock> seen_;
};

}  // namespace sightline
