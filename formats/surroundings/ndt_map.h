#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"
#include "formats/grid/cell_key.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// The tile that holds a cell (tile_m is a multiple of cell_m).
TileKey tile_of(const CellKey& cell, double cell_m, double tile_m);

// True when tiles of tile_m can hold whole cells of cell_m: an integer multiple, both positive.
bool is_tiling(double cell_m, double tile_m);

// One normal distribution: a valid cell of the map.
struct Nd {
  CellKey key;
  std::uint32_t point_count = 0;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();            // inside its cell
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();     // raw, divided by n - 1
  Eigen::Vector3d eigenvalues_m2 = Eigen::Vector3d::Zero();    // descending, never below 0, raw
  Eigen::Matrix3d eigenvectors = Eigen::Matrix3d::Identity();  // column i belongs to eigenvalue i
};

// Eigenvalues below 0.01 of the largest raised to it, eigenvectors kept (definition v1 in
// schemas/definitions.md): for matching and Mahalanobis distances.
Eigen::Matrix3d regularised_covariance_m2(const Nd& nd);

// Fills eigenvalues and eigenvectors from covariance_m2; the same input gives the same bits.
void decompose(Nd& nd);
// Of many the same, faster than one by one.
void decompose(std::span<Nd> nds);

// The dimension class of an ND: argmax(sigma1 - sigma2, sigma2 - sigma3, sigma3), first on a tie;
// 1, 2 or 3 (paper Eq. 1 times sigma1).
int dimension_class(const Nd& nd);

struct NdtMap {
  MapFrame frame;
  double cell_m = 2.0;
  double tile_m = 64.0;
  std::vector<Nd> nds;                      // valid cells only, ascending by (tile, cell key)
  std::uint64_t sparse_cell_count = 0;      // fewer points than an ND needs
  std::uint64_t degenerate_cell_count = 0;  // largest eigenvalue below 1e-6 m^2
  std::uint64_t point_count = 0;            // all points that fell into any cell
};
SIGHTLINE_FIELDS(NdtMap, frame, cell_m, tile_m, nds, sparse_cell_count, degenerate_cell_count,
                 point_count)
SIGHTLINE_ARTIFACT(NdtMap, "ndt-map", 1)

Result<void> validate(const NdtMap& map);
Table dump(const NdtMap& map);
// Without what follows from the covariance.
void encode(const Nd& nd, ByteWriter& writer);
void decode(ByteReader& reader, Nd& nd);
void encode(const NdtMap& map, ByteWriter& writer);
void decode(ByteReader& reader, NdtMap& map);

// A row is an ND, without what follows from its covariance.
template <>
struct RowsOf<NdtMap> : RowsInVector<NdtMap, Nd, &NdtMap::nds> {
  static std::size_t size(const NdtMap& /*head*/) {
    return 4 * sizeof(std::int32_t) + 9 * sizeof(double);
  }
  static NdtMap head_of(const NdtMap& map);
  // Without counts.
  static NdtMap part_of(const NdtMap& head, std::size_t first, std::size_t count);
  static void decode(ByteReader& reader, NdtMap& map, std::size_t first, std::size_t count);
  static TileKey tile(const NdtMap& head, std::span<const std::byte> row);
  static double reach_m(std::span<const std::byte> /*row*/) { return 0.0; }
};

// The NDs of a map, tile by tile.
using TiledNds = StoredTable<NdtMap>;

}  // namespace sightline
