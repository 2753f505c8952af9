#include "tests/bench/pcl_map.h"

#include <pcl/filters/voxel_grid.h>
#include <pcl/filters/voxel_grid_covariance.h>
#include <pcl/io/pcd_io.h>
#include <pcl/registration/ndt.h>

namespace sightline {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

}  // namespace

struct PclCloud::State {
  Cloud::Ptr cloud{new Cloud};
};

PclCloud::PclCloud(std::span<const Eigen::Vector3d> points_m) {
  const auto state = std::make_shared<State>();
  state->cloud->reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3f point = point_m.cast<float>();
    state->cloud->push_back(pcl::PointXYZ(point.x(), point.y(), point.z()));
  }
  state_ = state;
}

std::size_t PclCloud::build_cells(double cell_m) const {
  const auto edge = static_cast<float>(cell_m);
  pcl::VoxelGridCovariance<pcl::PointXYZ> cells;
  cells.setLeafSize(edge, edge, edge);
  cells.setInputCloud(state_->cloud);
  Cloud centroids;
  cells.filter(centroids, false);
  return centroids.size();
}

void PclCloud::make_ready_to_match(double cell_m) const {
  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setResolution(static_cast<float>(cell_m));
  ndt.setInputTarget(state_->cloud);
  // One point and no iteration: what is left is the tree.
  const Cloud::Ptr scan(new Cloud);
  scan->push_back((*state_->cloud)[0]);
  ndt.setInputSource(scan);
  ndt.setMaximumIterations(0);
  Cloud aligned;
  ndt.align(aligned);
}

std::size_t PclCloud::subsample(double leaf_m) const {
  const auto leaf = static_cast<float>(leaf_m);
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(state_->cloud);
  grid.setLeafSize(leaf, leaf, leaf);
  Cloud centroids;
  grid.filter(centroids);
  return centroids.size();
}

std::size_t load_with_pcl(const std::string& path) {
  pcl::PointCloud<pcl::PointXYZI> cloud;
  return pcl::io::loadPCDFile(path, cloud) == 0 ? cloud.size() : 0;
}

void compress_with_pcl(const std::string& from, const std::string& to) {
  pcl::PointCloud<pcl::PointXYZI> cloud;
  pcl::io::loadPCDFile(from, cloud);
  pcl::io::savePCDFileBinaryCompressed(to, cloud);
}

}  // namespace sightline
