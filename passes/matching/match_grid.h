#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "formats/base/huge_pages.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/kernel/match_kernel.h"

namespace sightline {

// The constants of the NDT score -d1 exp(-d2/2 m^2) of a point at Mahalanobis distance m, for an
// outlier ratio of 0.55 ("NDT map" in schemas/definitions.md, v1). At 2 m: d1 = -4.196518186951,
// d2 = 0.248478510124.
struct GaussConstants {
  double d1 = 0.0;
  double d2 = 0.0;
};
GaussConstants gauss_constants(double cell_m);

// An ND as the matcher needs it, in the map frame.
struct MatchNd {
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information_per_m2 = Eigen::Matrix3d::Zero();  // inverse regularised covariance
  std::uint8_t normal_class = 0;                                 // below kNormalClasses
};

// Directions of an ND's normal, its shortest axis: upright, else by azimuth, opposite ones alike.
inline constexpr std::size_t kAzimuthClasses = 4;
inline constexpr std::size_t kNormalClasses = kAzimuthClasses + 1;
std::uint8_t normal_class(const Eigen::Vector3d& normal);

// A map made ready for matching: for each cell that a point can score in, the NDs of that cell and
// of its six face neighbours, found by one look-up. A cell that none of these seven has an ND for
// is not listed.
struct MatchGrid {
  static constexpr std::int32_t kNone = -1;
  // Own cell, then the neighbours at -x, +x, -y, +y, -z, +z: indices into `nds` or kNone. The
  // eighth is always kNone and pads to a vector's width.
  using Neighbourhood = std::array<std::int32_t, 8>;

  double cell_m = 2.0;
  GaussConstants gauss;
  std::vector<MatchNd> nds;  // in the order of the map, those left out that no float can hold
  CellIndex cells;
  std::vector<Neighbourhood> neighbourhoods;  // of `cells`
  HugeVector<KernelRecord> records;           // of `cells`, in float, after one without any ND
  HugeVector<std::uint8_t> normal_classes;    // of `cells`: of the first ND that each has
  std::uint64_t cells_digest = 0;  // of `cells`: grids of one digest number the same cells alike
};

// Costs time and memory in proportion to the number of NDs.
MatchGrid make_match_grid(const NdtMap& map);

// The same with another opinion of what each ND says than its inverse regularised covariance.
using InformationOfNd = std::function<Eigen::Matrix3d(const Nd&)>;
MatchGrid make_match_grid(const NdtMap& map, const InformationOfNd& information_per_m2);

// The number of a cell, or MatchGrid::kNone.
std::int32_t find_cell(const MatchGrid& grid, const CellKey& key);

}  // namespace sightline
