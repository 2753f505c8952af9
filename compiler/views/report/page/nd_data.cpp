#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "compiler/views/report/page/json_numbers.h"
#include "compiler/views/report/page/page_data.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

constexpr double kSigmas = 2.0;
constexpr std::uint8_t kLyingPlane = 4;  // a kind beside the dimension classes

double lowest_z_m(const NdtMap& map) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Nd& nd : map.nds) lowest = std::min(lowest, nd.mean_m.z());
  return map.nds.empty() ? 0.0 : lowest;
}

std::uint16_t steps_of(double value, double step) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(value / step), 0L, 65535L));
}

std::uint8_t kind_of(const Nd& nd) {
  const int dimension = dimension_class(nd);
  const bool is_lying = std::abs(nd.eigenvectors(2, 2)) > std::numbers::sqrt2 / 2.0;
  return dimension == 2 && is_lying ? kLyingPlane : static_cast<std::uint8_t>(dimension);
}

// NDs of one tile, column by column.
struct NdColumns {
  std::vector<std::uint16_t> place, height, radius;
  std::vector<std::uint8_t> turn, kind;
};

void append(const Nd& nd, const Eigen::Vector3d& corner_m, double tile_m, NdColumns& columns) {
  constexpr double kMillimetre = 0.001;
  constexpr double kCentimetre = 0.01;
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(nd.covariance_m2.topLeftCorner<2, 2>());
  const auto radius_m = [&](int i) { return kSigmas * std::sqrt(std::max(0.0, eigen.values[i])); };
  const Eigen::Vector3d off_m = nd.mean_m - corner_m;
  columns.place.push_back(steps_of(off_m.x(), tile_m / 65535.0));
  columns.place.push_back(steps_of(off_m.y(), tile_m / 65535.0));
  columns.height.push_back(steps_of(off_m.z(), kCentimetre));
  columns.radius.push_back(steps_of(radius_m(1), kMillimetre));
  columns.radius.push_back(steps_of(radius_m(0), kMillimetre));
  const Eigen::Vector2d along = eigen.vectors.col(1);
  const double turn = std::atan2(along.y(), along.x()) * 256.0 / std::numbers::pi;
  columns.turn.push_back(static_cast<std::uint8_t>(std::lround(turn) & 255L));
  columns.kind.push_back(kind_of(nd));
}

}  // namespace

PageJson nds_json(const NdtMap& map) {
  const double lowest_m = lowest_z_m(map);
  PageJson tiles = PageJson::array();
  for (std::size_t begin = 0; begin < map.nds.size();) {
    const TileKey key = tile_of(map.nds[begin].key, map.cell_m, map.tile_m);
    const Eigen::Vector3d corner_m(key.x * map.tile_m, key.y * map.tile_m, lowest_m);
    NdColumns columns;
    std::size_t end = begin;
    for (; end < map.nds.size() && tile_of(map.nds[end].key, map.cell_m, map.tile_m) == key;
         ++end) {
      append(map.nds[end], corner_m, map.tile_m, columns);
    }
    tiles.push_back({{"x", key.x},
                     {"y", key.y},
                     {"count", end - begin},
                     {"place_m", json_numbers(columns.place)},
                     {"height", json_numbers(columns.height)},
                     {"radius", json_numbers(columns.radius)},
                     {"turn", json_numbers(columns.turn)},
                     {"kind", json_numbers(columns.kind)}});
    begin = end;
  }
  return {
      {"cell_m", map.cell_m}, {"tile_m", map.tile_m}, {"lowest_z_m", lowest_m}, {"tiles", tiles}};
}

}  // namespace sightline
