#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "formats/base/huge_pages.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/grid/cell_columns.h"
#include "passes/matching/grid/mapped_allocator.h"
#include "passes/matching/grid/packed_records.h"

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

// A map made ready for matching: for each cell that has an ND or is beside one, the NDs of the cell
// and of its six face neighbours, found by one look-up.
struct MatchGrid {
  static constexpr std::int32_t kNone = -1;
  // Own cell, then the neighbours at -x, +x, -y, +y, -z, +z: indices into `nds` or kNone. The
  // eighth is always kNone and pads to a vector's width.
  using Neighbourhood = std::array<std::int32_t, 8>;

  double cell_m = 2.0;
  GaussConstants gauss;
  MappedVector<MatchNd> nds;  // in the order of the map, those left out that no float can hold
  CellIndex cells;
  CellColumns columns;                         // of `cells`; empty in a grid that changes
  MappedVector<Neighbourhood> neighbourhoods;  // of `cells`
  PackedRecords records;                       // of `cells`, in float, after one without any ND
  HugeVector<std::uint8_t> normal_classes;     // of `cells`: of the first ND that each has
  // Of `cells`: 1 for one that has no ND any more and is not found. Empty in a grid made at once.
  std::vector<std::uint8_t> is_unused;
  // Of `cells` and `is_unused`: grids of one digest number the same cells alike.
  std::uint64_t cells_digest = 0;
};

// Costs time and memory in proportion to the number of NDs.
MatchGrid make_match_grid(const NdtMap& map);

// The same with another opinion of what each ND says than its inverse regularised covariance.
using InformationOfNd = std::function<Eigen::Matrix3d(const Nd&)>;
Eigen::Matrix3d plain_information_per_m2(const Nd& nd);  // that inverse
MatchGrid make_match_grid(const NdtMap& map, const InformationOfNd& information_per_m2);

// The number of a cell, or MatchGrid::kNone.
std::int32_t find_cell(const MatchGrid& grid, const CellKey& key);
// The number of its record; 0 for a cell that is not there. Looks into `columns` where it can.
std::int32_t record_of_cell(const MatchGrid& grid, const CellKey& key);
// Brings what that looks into first nearer.
void prefetch_cell(const MatchGrid& grid, const CellKey& key);

// make_match_grid() in steps, to the bit, for a caller that has little time at once.
class MatchGridBuilder {
 public:
  MatchGridBuilder(double cell_m, InformationOfNd information_per_m2);

  void reserve(std::size_t nd_count);
  void add(std::span<const Nd> nds);    // in the order of the map
  bool fill(std::size_t record_count);  // so many more records; true once all are filled
  MatchGrid finish();                   // the grid, of which all records are filled

 private:
  InformationOfNd information_per_m2_;
  MatchGrid grid_;
};

// Frees what only MatchKernel::kExact and nd_of_cell() read, more than half of a grid: these may no
// longer be used. Keeps a grid whole that has no columns.
void keep_for_kernels(MatchGrid& grid);

// Index of the ND in a cell, or MatchGrid::kNone.
inline std::int32_t nd_of_cell(const MatchGrid& grid, const CellKey& key) {
  const std::int32_t cell = find_cell(grid, key);
  if (cell == MatchGrid::kNone) return MatchGrid::kNone;
  return grid.neighbourhoods[static_cast<std::size_t>(cell)][0];
}

// A MatchGrid whose NDs can be added, changed and removed, in time in proportion to these. Scores
// are those of make_match_grid(), to the bit; NDs and cells are numbered otherwise, and up to half
// of the cells may be unused.
class RollingMatchGrid {
 public:
  explicit RollingMatchGrid(double cell_m);

  // What NDs of different cells say, in place of what those of their cells said before. One that
  // make_match_grid() would leave out is taken away.
  void put(std::span<const Nd> nds, const InformationOfNd& information_per_m2);
  void take_away(const CellKey& key);
  // To be called behind the last change, before the grid is looked at.
  void finish();
  [[nodiscard]] const MatchGrid& grid() const { return grid_; }

  static constexpr std::size_t kNeighbourCount = 7;  // a cell and the six beside it

 private:
  // Of the cells in whose neighbourhoods an ND lies, by its lane there.
  using CellNumbers = std::array<std::uint32_t, kNeighbourCount>;

  void put_some(std::span<const Nd> nds, const InformationOfNd& information_per_m2);
  // In a cell that has none.
  void add(const CellKey& key, const MatchNd& nd);
  void change(const CellKey& key, std::int32_t number, const MatchNd& nd);
  // Puts an ND, or kNone, into the neighbourhoods around a cell.
  void set_lanes(const CellKey& key, const CellNumbers& numbers, std::int32_t nd);
  // The same of the records alone.
  void fill_lanes(const CellKey& key, const CellNumbers& numbers, std::int32_t nd);
  void prefetch_records(const CellNumbers& numbers) const;
  // Cells that were not met before have empty neighbourhoods.
  CellNumbers numbers_around(const CellKey& key);
  std::size_t number_of(const CellKey& cell);

  MatchGrid grid_;
  std::vector<CellNumbers> numbers_of_nd_;  // of grid_.nds
  std::vector<std::int32_t> free_;          // of grid_.nds
  std::vector<std::int32_t> found_;         // of the NDs that are put
  std::size_t unused_count_ = 0;
};

}  // namespace sightline
