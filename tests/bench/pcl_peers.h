#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

// PCL's own tools for the same jobs, to compare with. PCL stays in its own .cpp: it must not see
// our vector flags, nor we its headers.

namespace sightline {

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

// The finite points of a PCD file that are not (0,0,0); empty where it cannot be read.
std::vector<Eigen::Vector3d> read_pcd_with_pcl(const std::string& path);

// PCL's NDT with our stop rule (it compares the square of a step with its epsilon), default step.
class PclNdt {
 public:
  PclNdt(std::span<const Eigen::Vector3d> map_points_m, double cell_m);
  ~PclNdt();
  PclNdt(const PclNdt&) = delete;
  PclNdt& operator=(const PclNdt&) = delete;
  void set_scan(std::span<const Eigen::Vector3d> points_m);
  Eigen::Matrix4d match(const Eigen::Matrix4d& T_map_start);
  // One evaluation of score, gradient and Hessian at a pose, after a first match; the score.
  double evaluate(const Eigen::Matrix4d& T_map_scan);

 private:
  struct State;
  State* state_;
};

}  // namespace sightline
