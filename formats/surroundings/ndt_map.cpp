#include "formats/surroundings/ndt_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

std::string place_of(std::size_t index) { return concat("nd ", index); }

Result<void> validate_nd(const Nd& nd, double cell_m, std::size_t index) {
  if (!nd.mean_m.allFinite() || !nd.covariance_m2.allFinite()) {
    return invalid_artifact("mean or covariance is not finite", place_of(index));
  }
  if (nd.point_count < 2) return invalid_artifact("fewer than 2 points", place_of(index));
  constexpr double kGridReach_cells = 0x1.0p30;
  if (nd.mean_m.cwiseAbs().maxCoeff() > kGridReach_cells * cell_m ||
      cell_key(nd.mean_m, cell_m) != nd.key) {
    return invalid_artifact("the mean is outside its cell", place_of(index));
  }
  const Eigen::Vector3d& lambda = nd.eigenvalues_m2;
  const bool descending = lambda[0] >= lambda[1] && lambda[1] >= lambda[2] && lambda[2] >= 0.0;
  if (!descending || !nd.eigenvectors.allFinite()) {
    return invalid_artifact("eigenvalues must be descending and not negative", place_of(index));
  }
  return {};
}

void set_axes(const SymmetricEigen<3>& eigen, Nd& nd) {
  for (int i = 0; i < 3; ++i) {
    nd.eigenvalues_m2[i] = std::max(0.0, eigen.values[2 - i]);
    nd.eigenvectors.col(i) = eigen.vectors.col(2 - i);
  }
}

std::pair<TileKey, CellKey> order_of(const Nd& nd, const NdtMap& map) {
  return {tile_of(nd.key, map.cell_m, map.tile_m), nd.key};
}

}  // namespace

TileKey tile_of(const CellKey& cell, double cell_m, double tile_m) {
  const auto cells_per_tile = static_cast<std::int32_t>(std::lround(tile_m / cell_m));
  return {floor_divide(cell.x, cells_per_tile), floor_divide(cell.y, cells_per_tile)};
}

bool is_tiling(double cell_m, double tile_m) {
  if (!(cell_m > 0.0) || !(tile_m >= cell_m) || !std::isfinite(tile_m)) return false;
  const double ratio = tile_m / cell_m;
  return ratio <= 1e6 && std::abs(ratio - std::round(ratio)) <= 1e-9 * ratio;
}

Eigen::Matrix3d regularised_covariance_m2(const Nd& nd) {
  // Keeps flat cells invertible without letting them become infinitely sharp.
  constexpr double kLeastShare = 0.01;
  const Eigen::Vector3d lambda = nd.eigenvalues_m2.cwiseMax(kLeastShare * nd.eigenvalues_m2[0]);
  const Eigen::Matrix3d covariance =
      nd.eigenvectors * lambda.asDiagonal() * nd.eigenvectors.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

void decompose(Nd& nd) { set_axes(symmetric_eigen<3>(nd.covariance_m2), nd); }

void decompose(std::span<Nd> nds) {
  constexpr std::size_t kAtOnce = 64;
  std::array<Eigen::Matrix3d, kAtOnce> covariances_m2;
  std::array<SymmetricEigen<3>, kAtOnce> found;
  for (; !nds.empty(); nds = nds.subspan(std::min(kAtOnce, nds.size()))) {
    const std::size_t count = std::min(kAtOnce, nds.size());
    for (std::size_t i = 0; i < count; ++i) covariances_m2[i] = nds[i].covariance_m2;
    symmetric_eigen(std::span(covariances_m2).first(count), std::span(found).first(count));
    for (std::size_t i = 0; i < count; ++i) set_axes(found[i], nds[i]);
  }
}

int dimension_class(const Nd& nd) {
  const Eigen::Vector3d sigma = nd.eigenvalues_m2.cwiseSqrt();
  const double linear = sigma[0] - sigma[1];
  const double planar = sigma[1] - sigma[2];
  if (linear >= planar && linear >= sigma[2]) return 1;
  return planar >= sigma[2] ? 2 : 3;
}

Result<void> validate(const NdtMap& map) {
  if (!is_tiling(map.cell_m, map.tile_m)) {
    return invalid_artifact(
        concat("a tile of ", std::to_string(map.tile_m), " m is not a multiple of a cell of ",
               std::to_string(map.cell_m), " m"),
        "");
  }
  if (!map.frame.origin_world_m.allFinite()) return invalid_artifact("the frame is not finite", "");
  for (std::size_t i = 0; i < map.nds.size(); ++i) {
    SIGHTLINE_TRY(validate_nd(map.nds[i], map.cell_m, i));
    if (i > 0 && !(order_of(map.nds[i - 1], map) < order_of(map.nds[i], map))) {
      return invalid_artifact("cells must ascend by tile and key", place_of(i));
    }
  }
  return {};
}

Table dump(const NdtMap& map) {
  Table table{"nds", {}, {}, {}};
  append_facts(map.frame, table);
  table.facts.emplace_back("cell_m", map.cell_m);
  table.facts.emplace_back("tile_m", map.tile_m);
  table.facts.emplace_back("point_count", static_cast<std::int64_t>(map.point_count));
  table.facts.emplace_back("sparse_cell_count", static_cast<std::int64_t>(map.sparse_cell_count));
  table.facts.emplace_back("degenerate_cell_count",
                           static_cast<std::int64_t>(map.degenerate_cell_count));
  table.columns = {"key_x",          "key_y",     "key_z",     "point_count", "mean_x_m",
                   "mean_y_m",       "mean_z_m",  "cov_xx_m2", "cov_xy_m2",   "cov_xz_m2",
                   "cov_yy_m2",      "cov_yz_m2", "cov_zz_m2", "lambda_1_m2", "lambda_2_m2",
                   "lambda_3_m2",    "e1_x",      "e1_y",      "e1_z",        "e2_x",
                   "e2_y",           "e2_z",      "e3_x",      "e3_y",        "e3_z",
                   "dimension_class"};
  table.rows.reserve(map.nds.size());
  for (const Nd& nd : map.nds) {
    std::vector<Cell> row = {std::int64_t{nd.key.x}, std::int64_t{nd.key.y}, std::int64_t{nd.key.z},
                             std::int64_t{nd.point_count}};
    for (int i = 0; i < 3; ++i) row.emplace_back(nd.mean_m[i]);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) row.emplace_back(nd.covariance_m2(i, j));
    }
    for (int i = 0; i < 3; ++i) row.emplace_back(nd.eigenvalues_m2[i]);
    for (int i = 0; i < 9; ++i) row.emplace_back(nd.eigenvectors(i % 3, i / 3));
    row.emplace_back(std::int64_t{dimension_class(nd)});
    table.rows.push_back(std::move(row));
  }
  return table;
}

void encode(const Nd& nd, ByteWriter& writer) {
  FieldWriter put(writer);
  put.put(nd.key);
  put.put(nd.point_count);
  put.put(nd.mean_m);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) writer.put(nd.covariance_m2(i, j));
  }
}

void decode(ByteReader& reader, Nd& nd) {
  FieldReader get(reader);
  get.get(nd.key);
  get.get(nd.point_count);
  get.get(nd.mean_m);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      reader.get(nd.covariance_m2(i, j));
      nd.covariance_m2(j, i) = nd.covariance_m2(i, j);
    }
  }
}

// A whole map has the bytes of its table.
void encode(const NdtMap& map, ByteWriter& writer) { encode_whole(map, writer); }
void decode(ByteReader& reader, NdtMap& map) { decode_whole(reader, map); }

NdtMap RowsOf<NdtMap>::head_of(const NdtMap& map) {
  NdtMap head = part_of(map, 0, 0);
  head.sparse_cell_count = map.sparse_cell_count;
  head.degenerate_cell_count = map.degenerate_cell_count;
  head.point_count = map.point_count;
  return head;
}

NdtMap RowsOf<NdtMap>::part_of(const NdtMap& head, std::size_t /*first*/, std::size_t /*count*/) {
  return {head.frame, head.cell_m, head.tile_m, {}, 0, 0, 0};
}

void RowsOf<NdtMap>::decode(ByteReader& reader, NdtMap& map, std::size_t first, std::size_t count) {
  RowsInVector::decode(reader, map, first, count);
  // Not stored: they follow from the covariance, to the bit.
  decompose(std::span(map.nds).subspan(first, count));
}

TileKey RowsOf<NdtMap>::tile(const NdtMap& head, std::span<const std::byte> row) {
  ByteReader reader(row);
  CellKey key;
  sightline::decode(reader, key);
  return tile_of(key, head.cell_m, head.tile_m);
}

}  // namespace sightline
