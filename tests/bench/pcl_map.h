#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

// PCL's own tools around the matcher, to compare with. PCL stays in its own .cpp.

namespace sightline {

// A cloud in PCL's own layout, made once and not measured.
class PclCloud {
 public:
  explicit PclCloud(std::span<const Eigen::Vector3d> points_m);

  // pcl::VoxelGridCovariance without its tree: the number of valid cells.
  [[nodiscard]] std::size_t build_cells(double cell_m) const;
  // setInputTarget of PCL's NDT, and the tree of the raw map that its first match makes.
  void make_ready_to_match(double cell_m) const;
  // pcl::VoxelGrid: the number of centroids.
  [[nodiscard]] std::size_t subsample(double leaf_m) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

// pcl::io::loadPCDFile: the number of points, 0 where it cannot be read.
std::size_t load_with_pcl(const std::string& path);

// The same points as binary_compressed.
void compress_with_pcl(const std::string& from, const std::string& to);

}  // namespace sightline
