#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sightline {

// The voxels that hold returns, numbered from 0 in the order of insertion, in an OctoMap octree.
// Free space is not stored: memory grows with the surface alone.
class VoxelIndex {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  // The octree reaches 32768 voxels from `centre_m` on each axis; faces of voxels lie at multiples
  // of voxel_m whatever the centre.
  VoxelIndex(double voxel_m, const Eigen::Vector3d& centre_m);
  ~VoxelIndex();
  VoxelIndex(VoxelIndex&&) noexcept;
  VoxelIndex& operator=(VoxelIndex&&) noexcept;

  // The voxel that holds a point, made where there is none; kNone beyond the octree.
  std::uint32_t insert(const Eigen::Vector3d& point_m);
  // The voxel that holds a point; kNone where no point was inserted.
  [[nodiscard]] std::uint32_t find(const Eigen::Vector3d& point_m) const;
  [[nodiscard]] std::size_t size() const;

 private:
  friend class RayWalk;
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

// Walks along rays; keeps its scratch between calls, so each thread has one of its own.
class RayWalk {
 public:
  explicit RayWalk(const VoxelIndex& voxels);  // which must outlive the walk
  ~RayWalk();
  RayWalk(RayWalk&&) noexcept;
  RayWalk& operator=(RayWalk&&) noexcept;

  // The voxels with returns that the segment passes, from the start on, the one of `to_m` left out.
  // The next call overwrites it.
  const std::vector<std::uint32_t>& along(const Eigen::Vector3d& from_m,
                                          const Eigen::Vector3d& to_m);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace sightline
