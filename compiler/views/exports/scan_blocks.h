#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/grid/cell_key.h"

namespace sightline {

// Voxels are handled in blocks of 4 x 4 x 4, one bit each. Bits 8 i to 8 i + 7 are the voxels of
// the i-th octant of the block; octants and voxels are in the order of an octree's children.
// Which child of its parent a cell is: bit 0 is x, bit 1 is y, bit 2 is z.
int child_of_parent(const CellKey& cell);

// The voxels of a block that one scan's rays pass, and those in which they end.
struct ScanVoxels {
  std::uint64_t free = 0;
  std::uint64_t occupied = 0;  // goes before `free`
};

// 4 x 4 x 4 blocks make a chunk. The block of a chunk with this number.
constexpr std::size_t kBlocksOfChunk = 64;
CellKey block_of_chunk(const CellKey& chunk, std::size_t number);

struct ChunkVoxels {
  CellKey key;
  std::array<ScanVoxels, kBlocksOfChunk> blocks{};
};

// The voxels along a ray (Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray
// tracing"). Of equal distances the last axis goes first.
struct VoxelRay {
  CellKey from;
  CellKey to;                          // not marked
  std::array<std::int32_t, 3> step{};  // along each axis: -1, 0 or 1
  std::array<double, 3> next_m{};      // along the ray to the next face of each axis
  std::array<double, 3> between_m{};   // along the ray from face to face
  double length_m = 0.0;               // no voxel that is left farther away is marked
};

// The voxels that one scan's rays meet, within a box. Takes one scan after another and keeps its
// memory, which follows the voxels met and 4 bytes for each 4096 voxels of the box.
class ScanBlocks {
 public:
  // Without a voxel again. All voxels to come are in the box; of rays, both ends are.
  void begin(const CellKey& low, const CellKey& high);
  void free_along(const VoxelRay& ray);
  void occupy(const CellKey& voxel);

  // In the order in which they were met.
  [[nodiscard]] std::span<const ChunkVoxels> chunks() const { return chunks_; }

 private:
  // A place: the number of its chunk in the box, of its block in the chunk and of its bit.
  [[nodiscard]] std::uint64_t place_of(const CellKey& voxel) const;
  // Adds the chunk where it is new. Ends the validity of references.
  ChunkVoxels& chunk_of(std::uint64_t place);

  std::array<std::int32_t, 3> first_{};              // the box's lowest voxel, of that chunk
  std::array<std::uint64_t, 3> size_{};              // in chunks
  std::array<std::vector<std::uint64_t>, 3> parts_;  // of places, by voxel from first_ on
  std::vector<std::uint32_t> number_of_chunk_;       // 1 and up in chunks_; 0: none yet
  std::vector<std::uint64_t> places_;                // of chunks_
  std::vector<ChunkVoxels> chunks_;
};

}  // namespace sightline
