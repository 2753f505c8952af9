#include "tests/bench/pcl_peers.h"

#include <pcl/filters/voxel_grid.h>
#include <pcl/filters/voxel_grid_covariance.h>
#include <pcl/io/pcd_io.h>
#include <pcl/registration/ndt.h>

namespace sightline {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr to_cloud(std::span<const Eigen::Vector3d> points_m) {
  const Cloud::Ptr cloud(new Cloud);
  cloud->reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3f point = point_m.cast<float>();
    cloud->push_back(pcl::PointXYZ(point.x(), point.y(), point.z()));
  }
  return cloud;
}

}  // namespace

struct PclCloud::State {
  Cloud::Ptr cloud;
};

PclCloud::PclCloud(std::span<const Eigen::Vector3d> points_m)
    : state_(std::make_shared<const State>(State{to_cloud(points_m)})) {}

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

std::vector<Eigen::Vector3d> read_pcd_with_pcl(const std::string& path) {
  Cloud cloud;
  std::vector<Eigen::Vector3d> points_m;
  if (pcl::io::loadPCDFile(path, cloud) != 0) return points_m;
  for (const pcl::PointXYZ& point : cloud) {
    const Eigen::Vector3d point_m(point.x, point.y, point.z);
    if (point_m.allFinite() && !point_m.isZero(0.0)) points_m.push_back(point_m);
  }
  return points_m;
}

class OpenNdt : public pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> {
 public:
  double evaluate(const Cloud& moved, const Eigen::Matrix<double, 6, 1>& motion) {
    Eigen::Matrix<double, 6, 1> gradient;
    Eigen::Matrix<double, 6, 6> hessian;
    return computeDerivatives(gradient, hessian, moved, motion);
  }
};

struct PclNdt::State {
  OpenNdt ndt;
  Cloud aligned;
};

PclNdt::PclNdt(std::span<const Eigen::Vector3d> map_points_m, double cell_m) : state_(new State) {
  state_->ndt.setResolution(static_cast<float>(cell_m));
  state_->ndt.setTransformationEpsilon(0.005 * 0.005);
  state_->ndt.setMaximumIterations(35);
  state_->ndt.setInputTarget(to_cloud(map_points_m));
}

PclNdt::~PclNdt() { delete state_; }

void PclNdt::set_scan(std::span<const Eigen::Vector3d> points_m) {
  state_->ndt.setInputSource(to_cloud(points_m));
}

Eigen::Matrix4d PclNdt::match(const Eigen::Matrix4d& T_map_start) {
  state_->ndt.align(state_->aligned, T_map_start.cast<float>());
  return state_->ndt.getFinalTransformation().cast<double>();
}

double PclNdt::evaluate(const Eigen::Matrix4d& T_map_scan) {
  const Eigen::Affine3d T(T_map_scan);
  Eigen::Matrix<double, 6, 1> motion;
  motion << T.translation(), T.rotation().eulerAngles(0, 1, 2);
  const Eigen::Matrix4f transform = T_map_scan.cast<float>();
  state_->aligned = *state_->ndt.getInputSource();
  for (pcl::PointXYZ& point : state_->aligned) {
    point.getVector4fMap() = transform * point.getVector4fMap();
  }
  return state_->ndt.evaluate(state_->aligned, motion);
}

}  // namespace sightline
