#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "formats/ndt_map.h"

namespace sightline {

// The voxels that hold returns, numbered from 0 in the order of insertion, in an OctoMap octree.
// Free space is not stored: memory grows with the surface alone.
class VoxelIndex {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  // The octree reaches 32767 voxels from `centre` on each axis.
  explicit VoxelIndex(const CellKey& centre);
  ~VoxelIndex();
  VoxelIndex(VoxelIndex&&) noexcept;
  VoxelIndex& operator=(VoxelIndex&&) noexcept;

  // The number of a voxel, made where there is none; kNone beyond the octree.
  std::uint32_t insert(const CellKey& key);
  // The number of a voxel; kNone where it was not inserted.
  [[nodiscard]] std::uint32_t find(const CellKey& key) const;
  [[nodiscard]] std::size_t size() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace sightline
