#include "passes/matching/coarse_map.h"

#include <map>
#include <utility>

#include "compiler/base/check.h"

namespace sightline {
namespace {

// Sums about the centre of the longer cell, where they lose least to rounding.
struct Moments {
  double count = 0.0;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products_m2 = Eigen::Matrix3d::Zero();
};

std::int32_t floor_quotient(std::int32_t value, int divisor) {
  const std::int32_t quotient = value / divisor;
  return quotient - (value % divisor < 0 ? 1 : 0);
}

Eigen::Vector3d centre_of(const CellKey& key, double cell_m) {
  return cell_m * Eigen::Vector3d(key.x + 0.5, key.y + 0.5, key.z + 0.5);
}

void add(const Nd& nd, const Eigen::Vector3d& centre_m, Moments& moments) {
  const double count = nd.point_count;
  const Eigen::Vector3d off_m = nd.mean_m - centre_m;
  moments.count += count;
  moments.sum_m += count * off_m;
  moments.products_m2 += (count - 1.0) * nd.covariance_m2 + count * off_m * off_m.transpose();
}

Nd to_nd(const CellKey& key, const Moments& moments, double cell_m) {
  const Eigen::Vector3d off_m = moments.sum_m / moments.count;
  Nd nd;
  nd.key = key;
  nd.point_count = static_cast<std::uint32_t>(moments.count);
  nd.mean_m = centre_of(key, cell_m) + off_m;
  nd.covariance_m2 =
      (moments.products_m2 - moments.count * off_m * off_m.transpose()) / (moments.count - 1.0);
  decompose(nd);
  return nd;
}

}  // namespace

NdtMap coarse_map(const NdtMap& map, int factor) {
  SIGHTLINE_CHECK(factor >= 1);
  NdtMap coarse = map;
  coarse.cell_m = factor * map.cell_m;
  while (!is_tiling(coarse.cell_m, coarse.tile_m)) coarse.tile_m += map.tile_m;
  std::map<std::pair<TileKey, CellKey>, Moments> cells;
  for (const Nd& nd : map.nds) {
    const CellKey key{floor_quotient(nd.key.x, factor), floor_quotient(nd.key.y, factor),
                      floor_quotient(nd.key.z, factor)};
    add(nd, centre_of(key, coarse.cell_m),
        cells[{tile_of(key, coarse.cell_m, coarse.tile_m), key}]);
  }
  coarse.nds.clear();
  for (const auto& [place, moments] : cells) {
    coarse.nds.push_back(to_nd(place.second, moments, coarse.cell_m));
  }
  return coarse;
}

}  // namespace sightline
