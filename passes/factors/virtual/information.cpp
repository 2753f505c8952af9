#include "passes/factors/virtual/information.h"

#include <algorithm>

#include "passes/matching/grid/match_grid.h"

namespace sightline {
namespace {

struct Sample {
  double distance_m = 0.0;
  std::size_t index = 0;
};

std::vector<Sample> nearest_first(std::span<const Eigen::Vector3d> points_m, double longest_m) {
  std::vector<Sample> samples;
  samples.reserve(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const double distance_m = points_m[i].norm();
    if (distance_m <= longest_m) samples.push_back({distance_m, i});
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.index < b.index;
  });
  return samples;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return matrix;
}

void add_point(const Eigen::Vector3d& p_map_m, const Eigen::Vector3d& r_m, const NdtMap& map,
               const MatchGrid& grid, ScanInformation& information) {
  ++information.point_count;
  const std::int32_t index = nd_of_cell(grid, cell_key(p_map_m + r_m, grid.cell_m));
  if (index == MatchGrid::kNone) {
    ++information.unmatched_count;
    return;
  }
  const auto i = static_cast<std::size_t>(index);
  add_sample(r_m, grid.nds[i].information_per_m2, information.pose);
  if (dimension_class(map.nds[i]) != 2) return;
  const Eigen::Vector2d normal = map.nds[i].eigenvectors.col(2).head<2>();
  information.planar_normals += normal * normal.transpose();
}

}  // namespace

// Block by block.
void add_sample(const Eigen::Vector3d& r_m, const Eigen::Matrix3d& information_per_m2,
                Matrix6d& pose) {
  const Eigen::Matrix3d cross = cross_matrix(r_m);
  const Eigen::Matrix3d A_cross = information_per_m2 * cross;
  pose.topLeftCorner<3, 3>() += information_per_m2;
  pose.topRightCorner<3, 3>() -= A_cross;
  pose.bottomLeftCorner<3, 3>() -= A_cross.transpose();
  pose.bottomRightCorner<3, 3>() += cross.transpose() * A_cross;
}

std::vector<ScanInformation> scan_information(const Eigen::Vector3d& p_map_m,
                                              std::span<const Eigen::Vector3d> points_m,
                                              const NdtMap& map, const MatchGrid& grid,
                                              const std::vector<double>& ranges_m) {
  const std::vector<Sample> samples = nearest_first(points_m, ranges_m.back());
  std::vector<ScanInformation> by_range;
  ScanInformation sum;
  std::size_t next = 0;
  for (const double range_m : ranges_m) {
    for (; next < samples.size() && samples[next].distance_m <= range_m; ++next) {
      add_point(p_map_m, points_m[samples[next].index], map, grid, sum);
    }
    by_range.push_back(sum);
  }
  return by_range;
}

}  // namespace sightline
