#include "passes/matching/match_grid.h"

#include <Eigen/LU>
#include <bit>
#include <span>

#include "compiler/base/hash.h"
#include "compiler/base/portable_math.h"

namespace sightline {
namespace {

constexpr std::size_t kNeighbourCount = 7;
constexpr std::array<CellKey, kNeighbourCount> kNeighbours = {
    {{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

std::uint64_t hash(const CellKey& key) {
  const std::uint64_t mixed = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ULL ^
                              static_cast<std::uint32_t>(key.y) * 0xbf58476d1ce4e5b9ULL ^
                              static_cast<std::uint32_t>(key.z) * 0x94d049bb133111ebULL;
  return mixed >> 32;
}

// Where `key` is, or the free slot where it belongs. `slots` has a power of two of them, not all
// taken.
std::size_t slot_of(const MatchGrid& grid, const CellKey& key) {
  const std::size_t mask = grid.slots.size() - 1;
  std::size_t slot = hash(key) & mask;
  while (grid.slots[slot] != MatchGrid::kNone &&
         grid.cells[static_cast<std::size_t>(grid.slots[slot])] != key) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

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
    const std::size_t slot = slot_of(grid, cell);
    if (grid.slots[slot] == MatchGrid::kNone) {
      grid.slots[slot] = static_cast<std::int32_t>(grid.cells.size());
      grid.cells.push_back(cell);
      grid.neighbourhoods.push_back(empty_neighbourhood());
    }
    grid.neighbourhoods[static_cast<std::size_t>(grid.slots[slot])][i] = nd;
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
  const Eigen::Vector3d centre_m =
      grid.cell_m * Eigen::Vector3d(cell.x + 0.5, cell.y + 0.5, cell.z + 0.5);
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
  // At most 7 cells an ND; half of the slots stay free.
  grid.slots.assign(std::bit_ceil(2 * kNeighbourCount * map.nds.size() + 2), MatchGrid::kNone);
  for (const Nd& nd : map.nds) {
    const MatchNd usable{nd.mean_m, information_per_m2(nd)};
    if (!is_usable(usable)) continue;
    list_in_neighbourhoods(nd.key, static_cast<std::int32_t>(grid.nds.size()), grid);
    grid.nds.push_back(usable);
  }
  grid.records.reserve(grid.cells.size() + 1);
  grid.records.push_back(make_record(grid, {}, empty_neighbourhood()));
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    grid.records.push_back(make_record(grid, grid.cells[i], grid.neighbourhoods[i]));
  }
  grid.cells_digest = xxh3(std::as_bytes(std::span(grid.cells)));
  return grid;
}

std::int32_t find_cell(const MatchGrid& grid, const CellKey& key) {
  return grid.slots.empty() ? MatchGrid::kNone : grid.slots[slot_of(grid, key)];
}

}  // namespace sightline
