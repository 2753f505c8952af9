#include "passes/map/build_ndt_cells.h"

#include <cmath>
#include <limits>

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The computed mean may round onto a face of its cell.
double inside_cell(double mean_m, std::int32_t key, double cell_m) {
  if (floor_to_int(mean_m / cell_m) > key) mean_m = (key + 1.0) * cell_m;
  if (floor_to_int(mean_m / cell_m) < key) mean_m = key * cell_m;
  while (floor_to_int(mean_m / cell_m) > key) mean_m = std::nextafter(mean_m, -kInfinity);
  while (floor_to_int(mean_m / cell_m) < key) mean_m = std::nextafter(mean_m, kInfinity);
  return mean_m;
}

}  // namespace

void CellSums::add(std::span<const Eigen::Vector3d> points_m, const Eigen::Vector3d& centre_m) {
  const Eigen::Array2d centre_xy_m = centre_m.head<2>();
  CellSums sums = *this;  // in registers
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Array2d from_xy_m = point_m.head<2>().array() - centre_xy_m;
    const double from_z_m = point_m.z() - centre_m.z();
    sums.x_y += from_xy_m;
    sums.z += from_z_m;
    sums.xx_yy += from_xy_m * from_xy_m;
    sums.xz_yz += from_xy_m * from_z_m;
    sums.zz_xy += Eigen::Array2d(from_z_m, from_xy_m[0]) * Eigen::Array2d(from_z_m, from_xy_m[1]);
  }
  sums.count += points_m.size();
  *this = sums;
}

void add_runs(std::span<const Eigen::Vector3d> points_m, std::span<const CellRun> runs,
              double cell_m, NdtCells& cells) {
  cells.add(runs, [&](CellSums& sums, const CellRun& run) {
    sums.add(points_m.subspan(run.begin, run.count), cell_centre_m(run.key, cell_m));
  });
}

Nd nd_of(const CellKey& key, const CellSums& sums, double cell_m) {
  const double n = static_cast<double>(sums.count);
  const Eigen::Vector3d sum_m(sums.x_y[0], sums.x_y[1], sums.z);
  Eigen::Matrix3d outer;                                 // the upper half
  outer << sums.xx_yy[0], sums.zz_xy[1], sums.xz_yz[0],  //
      0.0, sums.xx_yy[1], sums.xz_yz[1],                 //
      0.0, 0.0, sums.zz_xy[0];
  const Eigen::Vector3d from_centre_m = sum_m / n;
  Nd nd;
  nd.key = key;
  nd.point_count = static_cast<std::uint32_t>(sums.count);
  nd.mean_m = cell_centre_m(key, cell_m) + from_centre_m;
  nd.mean_m.x() = inside_cell(nd.mean_m.x(), key.x, cell_m);
  nd.mean_m.y() = inside_cell(nd.mean_m.y(), key.y, cell_m);
  nd.mean_m.z() = inside_cell(nd.mean_m.z(), key.z, cell_m);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const double moment = outer(i, j) - from_centre_m[i] * sum_m[j];
      nd.covariance_m2(i, j) = nd.covariance_m2(j, i) = moment / (n - 1.0);
    }
  }
  decompose(nd);
  return nd;
}

}  // namespace sightline
