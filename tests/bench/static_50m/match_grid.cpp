#include "tests/bench/static_50m/match_grid.h"

#include <Eigen/LU>
#include <span>

#include "formats/base/hash.h"
#include "formats/base/portable_math.h"

namespace sightline::static_50m {
namespace {

constexpr std::size_t kNeighbourCount = 7;
constexpr std::array<CellKey, kNeighbourCount> kNeighbours = {
    {{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

MatchGrid::Neighbourhood empty_neighbourhood() {
  MatchGrid::Neighbourhood none;
  none.fill(MatchGrid::kNone);
  return none;
}

// An ND in cell k is the neighbour `kNeighbours[i]` of the cell k - kNeighbours[i].
void list_in_neighbourhoods(const CellKey& key, std::int32_t nd, MatchGrid& grid) {
  for (std::size_t i = 0; i < kNeighbourCount; ++i) {
    const CellKey cell{key.x - kNeighbours[i].x, key.y - kNeighbours[i].y,
                       key.z - kNeighbours[i].z};
    const std::uint32_t number = grid.cells.add(cell);
    if (number == grid.neighbourhoods.size()) grid.neighbourhoods.push_back(empty_neighbourhood());
    grid.neighbourhoods[number][i] = nd;
  }
}

// So far off that the term vanishes, with numbers that overflow nowhere.
void set_absent(std::size_t lane, KernelRecord& record) {
  for (float(&mean_m)[8] : record.mean_m) mean_m[lane] = 1e3f;
  for (float(&information)[8] : record.information_per_m2) information[lane] = 0.0f;
  for (const int diagonal : {0, 3, 5}) record.information_per_m2[diagonal][lane] = 1.0f;
}

void set_nd(const MatchNd& nd, const Eigen::Vector3d& centre_m, double d2, std::size_t lane,
            KernelRecord& record) {
  int element = 0;
  for (int i = 0; i < 3; ++i) {
    record.mean_m[i][lane] = static_cast<float>(nd.mean_m[i] - centre_m[i]);
    for (int j = i; j < 3; ++j) {
      record.information_per_m2[element++][lane] =
          static_cast<float>(d2 * nd.information_per_m2(i, j));
    }
  }
}

KernelRecord make_record(const MatchGrid& grid, const CellKey& cell,
                         const MatchGrid::Neighbourhood& neighbourhood) {
  const Eigen::Vector3d centre_m = cell_centre_m(cell, grid.cell_m);
  KernelRecord record;
  for (std::size_t lane = 0; lane < neighbourhood.size(); ++lane) {
    if (neighbourhood[lane] == MatchGrid::kNone) {
      set_absent(lane, record);
    } else {
      const MatchNd& nd = grid.nds[static_cast<std::size_t>(neighbourhood[lane])];
      set_nd(nd, centre_m, grid.gauss.d2, lane, record);
    }
  }
  return record;
}

// Sharper than any valid ND can be (schemas/definitions.md: lambda_1 >= 1e-6 m^2), and too sharp
// for float.
bool is_usable(const MatchNd& nd) {
  constexpr double kLargestInformation_per_m2 = 1e9;
  return nd.mean_m.allFinite() && nd.information_per_m2.allFinite() &&
         nd.information_per_m2.cwiseAbs().maxCoeff() <= kLargestInformation_per_m2;
}

}  // namespace

GaussConstants gauss_constants(double cell_m) {
  constexpr double kOutlierRatio = 0.55;
  const double c1 = 10.0 * (1.0 - kOutlierRatio);
  const double c2 = kOutlierRatio / (cell_m * cell_m * cell_m);
  constexpr double kExpOfMinusHalf = 0.60653065971263342;
  const double d3 = -portable_log(c2);
  const double d1 = -portable_log(c1 + c2) - d3;
  const double d2 = -2.0 * portable_log((-portable_log(c1 * kExpOfMinusHalf + c2) - d3) / d1);
  return {d1, d2};
}

MatchGrid make_match_grid(const NdtMap& map) {
  return make_match_grid(
      map, [](const Nd& nd) -> Eigen::Matrix3d { return regularised_covariance_m2(nd).inverse(); });
}

MatchGrid make_match_grid(const NdtMap& map, const InformationOfNd& information_per_m2) {
  MatchGrid grid;
  grid.cell_m = map.cell_m;
  grid.gauss = gauss_constants(map.cell_m);
  grid.nds.reserve(map.nds.size());
  for (const Nd& nd : map.nds) {
    const MatchNd usable{nd.mean_m, information_per_m2(nd)};
    if (!is_usable(usable)) continue;
    list_in_neighbourhoods(nd.key, static_cast<std::int32_t>(grid.nds.size()), grid);
    grid.nds.push_back(usable);
  }
  grid.records.reserve(grid.cells.size() + 1);
  grid.records.push_back(make_record(grid, {}, empty_neighbourhood()));
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    grid.records.push_back(make_record(grid, grid.cells.keys()[i], grid.neighbourhoods[i]));
  }
  grid.cells_digest = xxh3(std::as_bytes(std::span(grid.cells.keys())));
  return grid;
}

std::int32_t find_cell(const MatchGrid& grid, const CellKey& key) {
  static_assert(MatchGrid::kNone == static_cast<std::int32_t>(CellIndex::kNone));
  return static_cast<std::int32_t>(grid.cells.find(key));
}

}  // namespace sightline::static_50m
