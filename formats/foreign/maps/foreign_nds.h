#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/grid/cell_key.h"
#include "formats/text/table.h"

namespace sightline {

// A cell of somebody's NDT map.
struct ForeignNd {
  CellKey key_world;               // of the grid that begins at the world's origin
  std::uint32_t point_count = 0;   // 2 or more
  Eigen::Vector3d mean_in_cell_m;  // from the cell's lower corner, inside the cell
  Eigen::Matrix3d covariance_m2;   // raw, divided by n - 1
};

// Somebody's finished NDT map: cells and no points. Means are kept beside their cells, since a
// world of UTM is millions of metres wide.
struct ForeignNds {
  std::string name;
  std::string world = "local";  // that the map says it lies in (formats/geodesy.h, parse_world)
  double cell_m = 0.0;
  std::vector<ForeignNd> nds;            // ascending by key, each key once
  std::uint64_t single_point_count = 0;  // cells of fewer than 2 points, which are left out
  std::uint64_t point_count = 0;         // of all cells, those left out too
  std::vector<std::string> warnings;
  Digest digest{};  // of names and contents: equal for equal maps, wherever they lie
};

template <>
struct ArtifactTraits<ForeignNds> {
  static constexpr std::string_view kName = "foreign-nds";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const ForeignNds& map);
Table dump(const ForeignNds& map);

}  // namespace sightline
