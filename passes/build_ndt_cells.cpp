#include "passes/build_ndt_cells.h"

#include <algorithm>
#include <cmath>

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

std::vector<CellSums> CellTable::take() {
  std::sort(cells_.begin(), cells_.end(),
            [](const CellSums& a, const CellSums& b) { return a.key < b.key; });
  std::vector<CellSums> cells = std::move(cells_);
  *this = CellTable();
  return cells;
}

void CellTable::grow() {
  slots_.assign(2 * slots_.size(), kFree);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    std::size_t slot = hash(cells_[i].key) & (slots_.size() - 1);
    while (slots_[slot] != kFree) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<std::uint32_t>(i);
  }
}

Nd nd_of(const CellSums& sums, double cell_m) {
  const double n = sums.count;
  Eigen::Matrix3d outer;
  outer << sums.xx, sums.xy, sums.xz, sums.xy, sums.yy, sums.yz, sums.xz, sums.yz, sums.zz;
  const Eigen::Vector3d from_centre_m = sums.sum_m / n;
  Nd nd;
  nd.key = sums.key;
  nd.point_count = sums.count;
  nd.mean_m = cell_centre_m(sums.key, cell_m) + from_centre_m;
  nd.mean_m.x() = inside_cell(nd.mean_m.x(), sums.key.x, cell_m);
  nd.mean_m.y() = inside_cell(nd.mean_m.y(), sums.key.y, cell_m);
  nd.mean_m.z() = inside_cell(nd.mean_m.z(), sums.key.z, cell_m);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const double moment = outer(i, j) - from_centre_m[i] * sums.sum_m[j];
      nd.covariance_m2(i, j) = nd.covariance_m2(j, i) = moment / (n - 1.0);
    }
  }
  decompose(nd);
  return nd;
}

}  // namespace sightline
