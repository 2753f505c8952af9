// What PCL's libraries hold for all types of points is compiled here for the one that is used: to
// load those libraries took two thirds of the time in which the program starts.
#define PCL_NO_PRECOMPILE

#include "passes/localize/pcl/pcl_ndt.h"

#include <pcl/registration/ndt.h>

#include <Eigen/LU>

namespace sightline {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Grid = pcl::VoxelGridCovariance<pcl::PointXYZ>;

Cloud::Ptr to_cloud(std::span<const Eigen::Vector3d> points_m) {
  const Cloud::Ptr cloud(new Cloud);
  cloud->reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3f point = point_m.cast<float>();
    cloud->push_back(pcl::PointXYZ(point.x(), point.y(), point.z()));
  }
  return cloud;
}

// Names what a grid keeps to itself, so that cells can be put in that are known already.
struct GridParts : Grid {
  static constexpr auto kLeaves = &GridParts::leaves_;
  static constexpr auto kLeafOfCentroid = &GridParts::voxel_centroids_leaf_indices_;
  static constexpr auto kCentroids = &GridParts::voxel_centroids_;
  static constexpr auto kTree = &GridParts::kdtree_;
};

Grid::Leaf leaf_of(const Nd& nd) {
  Grid::Leaf leaf;
  leaf.nr_points = static_cast<int>(nd.point_count);
  leaf.mean_ = nd.mean_m;
  leaf.centroid = Eigen::VectorXf::Zero(4);
  leaf.centroid.head<3>() = nd.mean_m.cast<float>();
  leaf.cov_ = regularised_covariance_m2(nd);
  leaf.icov_ = leaf.cov_.inverse();
  leaf.evals_ = nd.eigenvalues_m2.reverse();
  leaf.evecs_ = nd.eigenvectors.rowwise().reverse();
  return leaf;
}

class Ndt : public pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> {
 public:
  void set_numbers(double cell_m) {
    setStepSize(PclNdt::kStep_m);
    setTransformationEpsilon(PclNdt::kEpsilon_m * PclNdt::kEpsilon_m);
    setMaximumIterations(PclNdt::kIterations);
    setResolution(static_cast<float>(cell_m));
  }

  // PCL builds its grid of whatever target it is given: of a handful of points that make one cell,
  // which the NDs then take the place of.
  void set_nds(std::span<const Nd> nds) {
    std::vector<Eigen::Vector3d> one_cell_m;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sides((corner & 1) != 0 ? 0.1 : 0.2, (corner & 2) != 0 ? 0.1 : 0.2,
                                  (corner & 4) != 0 ? 0.1 : 0.2);
      one_cell_m.push_back(sides);
    }
    setInputTarget(to_cloud(one_cell_m));
    const Cloud::Ptr centroids(new Cloud);
    target_cells_.*GridParts::kLeaves = {};
    (target_cells_.*GridParts::kLeafOfCentroid).clear();
    for (std::size_t i = 0; i < nds.size(); ++i) {
      const Eigen::Vector3f mean = nds[i].mean_m.cast<float>();
      centroids->push_back(pcl::PointXYZ(mean.x(), mean.y(), mean.z()));
      (target_cells_.*GridParts::kLeaves)[i] = leaf_of(nds[i]);
      (target_cells_.*GridParts::kLeafOfCentroid).push_back(static_cast<int>(i));
    }
    target_cells_.*GridParts::kCentroids = centroids;
    if (!nds.empty()) (target_cells_.*GridParts::kTree).setInputCloud(centroids);
  }
};

}  // namespace

struct PclNdt::State {
  Ndt ndt;
  Cloud aligned;
  bool has_target = false;
  bool has_scan = false;
};

PclNdt::PclNdt(const NdtMap& map, const Eigen::Vector3d& place_map_m) : state_(new State) {
  std::vector<Nd> near;
  for (const Nd& nd : map.nds) {
    if ((nd.mean_m - place_map_m).squaredNorm() <= kReach_m * kReach_m) near.push_back(nd);
  }
  state_->ndt.set_numbers(map.cell_m);
  state_->ndt.set_nds(near);
  state_->has_target = !near.empty();
}

PclNdt::PclNdt(std::span<const Eigen::Vector3d> map_points_m, double cell_m, int fewest)
    : state_(new State) {
  state_->ndt.set_numbers(cell_m);
  state_->ndt.setMinPointPerVoxel(static_cast<unsigned int>(fewest));
  state_->ndt.setInputTarget(to_cloud(map_points_m));
  state_->has_target = true;
}

PclNdt::~PclNdt() = default;
PclNdt::PclNdt(PclNdt&&) noexcept = default;
PclNdt& PclNdt::operator=(PclNdt&&) noexcept = default;

void PclNdt::set_scan(std::span<const Eigen::Vector3d> points_m) {
  state_->has_scan = !points_m.empty();
  if (state_->has_scan) state_->ndt.setInputSource(to_cloud(points_m));
}

PclMatch PclNdt::match(const Pose& T_map_start) {
  if (!state_->has_target || !state_->has_scan) return {T_map_start, 0};
  state_->ndt.align(state_->aligned, T_map_start.matrix().cast<float>());
  const Eigen::Matrix4d found = state_->ndt.getFinalTransformation().cast<double>();
  PclMatch match{T_map_start, state_->ndt.getFinalNumIteration()};
  if (found.allFinite()) match.T_map_scan.matrix() = found;
  return match;
}

bool has_pcl_ndt() { return true; }

}  // namespace sightline
