#include "passes/matching/grid/match_grid.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/hash.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr std::size_t kNeighbourCount = RollingMatchGrid::kNeighbourCount;
constexpr std::array<CellKey, kNeighbourCount> kNeighbours = {
    {{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

MatchGrid::Neighbourhood empty_neighbourhood() {
  MatchGrid::Neighbourhood none;
  none.fill(MatchGrid::kNone);
  return none;
}

// An ND in cell k is the neighbour `kNeighbours[i]` of the cell k - kNeighbours[i].
CellKey neighbouring(const CellKey& key, std::size_t i) {
  return {key.x - kNeighbours[i].x, key.y - kNeighbours[i].y, key.z - kNeighbours[i].z};
}

void list_in_neighbourhoods(const CellKey& key, std::int32_t nd, MatchGrid& grid) {
  for (std::size_t i = 0; i < kNeighbourCount; ++i) {
    const std::uint32_t number = grid.cells.add(neighbouring(key, i));
    if (number == grid.neighbourhoods.size()) grid.neighbourhoods.push_back(empty_neighbourhood());
    grid.neighbourhoods[number][i] = nd;
  }
}

// Bit i: whether there is an ND in lane i.
unsigned used_lanes(const MatchGrid::Neighbourhood& neighbourhood) {
  unsigned used = 0;
  for (std::size_t lane = 0; lane < neighbourhood.size(); ++lane) {
    used |= (neighbourhood[lane] != MatchGrid::kNone ? 1u : 0u) << lane;
  }
  return used;
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

std::uint8_t class_of(const MatchGrid& grid, const MatchGrid::Neighbourhood& neighbourhood) {
  for (const std::int32_t nd : neighbourhood) {
    if (nd != MatchGrid::kNone) return grid.nds[static_cast<std::size_t>(nd)].normal_class;
  }
  return 0;
}

// Sharper than any valid ND can be (schemas/definitions.md: lambda_1 >= 1e-6 m^2), and too sharp
// for float.
bool is_usable(const MatchNd& nd) {
  constexpr double kLargestInformation_per_m2 = 1e9;
  return nd.mean_m.allFinite() && nd.information_per_m2.allFinite() &&
         nd.information_per_m2.cwiseAbs().maxCoeff() <= kLargestInformation_per_m2;
}

}  // namespace

std::uint8_t normal_class(const Eigen::Vector3d& normal) {
  constexpr double kUpright = 0.7;
  if (std::abs(normal.z()) > kUpright) return 0;
  // The quadrant of twice the azimuth: opposite normals have the same.
  const double cos2 = normal.x() * normal.x() - normal.y() * normal.y();
  const double sin2 = 2.0 * normal.x() * normal.y();
  static_assert(kAzimuthClasses == 4);
  if (std::abs(cos2) >= std::abs(sin2)) return cos2 >= 0.0 ? 1 : 2;
  return sin2 >= 0.0 ? 3 : 4;
}

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
  return make_match_grid(map, plain_information_per_m2);
}

Eigen::Matrix3d plain_information_per_m2(const Nd& nd) {
  return regularised_covariance_m2(nd).inverse();
}

MatchGrid make_match_grid(const NdtMap& map, const InformationOfNd& information_per_m2) {
  MatchGridBuilder builder(map.cell_m, information_per_m2);
  builder.reserve(map.nds.size());
  builder.add(map.nds);
  builder.fill(std::numeric_limits<std::size_t>::max());
  return builder.finish();
}

MatchGridBuilder::MatchGridBuilder(double cell_m, InformationOfNd information_per_m2)
    : information_per_m2_(std::move(information_per_m2)) {
  grid_.cell_m = cell_m;
  grid_.gauss = gauss_constants(cell_m);
}

void MatchGridBuilder::reserve(std::size_t nd_count) {
  constexpr std::size_t kCellsOfNd = 5;  // what is not used is never touched
  grid_.nds.reserve(nd_count);
  grid_.neighbourhoods.reserve(kCellsOfNd * nd_count);
}

void MatchGridBuilder::add(std::span<const Nd> nds) {
  SIGHTLINE_CHECK(grid_.records.places.empty());
  for (const Nd& nd : nds) {
    const MatchNd usable{nd.mean_m, information_per_m2_(nd), normal_class(nd.eigenvectors.col(2))};
    if (!is_usable(usable)) continue;
    list_in_neighbourhoods(nd.key, static_cast<std::int32_t>(grid_.nds.size()), grid_);
    grid_.nds.push_back(usable);
  }
}

bool MatchGridBuilder::fill(std::size_t record_count) {
  const std::size_t cell_count = grid_.cells.size();
  if (grid_.records.places.empty()) {
    grid_.records.reserve(cell_count + 1);
    grid_.normal_classes.reserve(cell_count);
    grid_.records.append(make_record(grid_, {}, empty_neighbourhood()), 0);
  }
  const std::size_t begin = grid_.normal_classes.size();
  const std::size_t end = begin + std::min(record_count, cell_count - begin);
  for (std::size_t i = begin; i < end; ++i) {
    grid_.records.append(make_record(grid_, grid_.cells.keys()[i], grid_.neighbourhoods[i]),
                         used_lanes(grid_.neighbourhoods[i]));
    grid_.normal_classes.push_back(class_of(grid_, grid_.neighbourhoods[i]));
  }
  return end == cell_count;
}

MatchGrid MatchGridBuilder::finish() {
  SIGHTLINE_CHECK(grid_.records.places.size() == grid_.cells.size() + 1);
  grid_.cells_digest = xxh3(std::as_bytes(std::span(grid_.cells.keys())));
  grid_.columns = CellColumns(grid_.cells.keys());
  return std::move(grid_);
}

void keep_for_kernels(MatchGrid& grid) {
  if (grid.columns.is_empty()) return;
  // An assignment of {} would keep a vector's memory.
  MappedVector<MatchNd>().swap(grid.nds);
  MappedVector<MatchGrid::Neighbourhood>().swap(grid.neighbourhoods);
  grid.cells = CellIndex();
}

RollingMatchGrid::RollingMatchGrid(double cell_m) {
  grid_.cell_m = cell_m;
  grid_.gauss = gauss_constants(cell_m);
  grid_.records.append_whole(make_record(grid_, {}, empty_neighbourhood()));
}

std::size_t RollingMatchGrid::number_of(const CellKey& cell) {
  const std::size_t number = grid_.cells.add(cell);
  if (number == grid_.neighbourhoods.size()) {
    grid_.neighbourhoods.push_back(empty_neighbourhood());
    grid_.records.append_whole(KernelRecord(grid_.records.memory.front()));
    grid_.normal_classes.push_back(0);
    grid_.is_unused.push_back(1);
    ++unused_count_;
  }
  return number;
}

RollingMatchGrid::CellNumbers RollingMatchGrid::numbers_around(const CellKey& key) {
  CellNumbers numbers{};
  for (std::size_t i = 0; i < kNeighbourCount; ++i) grid_.cells.prefetch(neighbouring(key, i));
  for (std::size_t i = 0; i < kNeighbourCount; ++i) {
    numbers[i] = static_cast<std::uint32_t>(number_of(neighbouring(key, i)));
  }
  return numbers;
}

// They lie far apart in memory: all are asked for before the first is needed.
void RollingMatchGrid::prefetch_records(const CellNumbers& numbers) const {
  constexpr std::size_t kLine = 64;
  for (const std::uint32_t number : numbers) {
    const auto* record = reinterpret_cast<const char*>(&grid_.records.memory[number + 1]);
    for (std::size_t at = 0; at < sizeof(KernelRecord); at += kLine) {
      __builtin_prefetch(record + at, 1);
    }
  }
}

void RollingMatchGrid::set_lanes(const CellKey& key, const CellNumbers& numbers, std::int32_t nd) {
  for (const std::uint32_t number : numbers) {
    __builtin_prefetch(&grid_.neighbourhoods[number], 1);
    __builtin_prefetch(&grid_.normal_classes[number], 1);
  }
  prefetch_records(numbers);
  for (std::size_t i = 0; i < kNeighbourCount; ++i) {
    const std::uint32_t number = numbers[i];
    MatchGrid::Neighbourhood& neighbourhood = grid_.neighbourhoods[number];
    neighbourhood[i] = nd;
    unused_count_ -= grid_.is_unused[number];
    grid_.is_unused[number] = used_lanes(neighbourhood) == 0 ? 1 : 0;
    unused_count_ += grid_.is_unused[number];
    if (nd == MatchGrid::kNone) set_absent(i, grid_.records.memory[number + 1]);
    grid_.normal_classes[number] = class_of(grid_, neighbourhood);
  }
  if (nd != MatchGrid::kNone) fill_lanes(key, numbers, nd);
}

void RollingMatchGrid::fill_lanes(const CellKey& key, const CellNumbers& numbers, std::int32_t nd) {
  const MatchNd& record = grid_.nds[static_cast<std::size_t>(nd)];
  for (std::size_t i = 0; i < kNeighbourCount; ++i) {
    const Eigen::Vector3d centre_m = cell_centre_m(neighbouring(key, i), grid_.cell_m);
    set_nd(record, centre_m, grid_.gauss.d2, i, grid_.records.memory[numbers[i] + 1]);
  }
}

void RollingMatchGrid::put(std::span<const Nd> nds, const InformationOfNd& information_per_m2) {
  constexpr std::size_t kAtOnce = 64;  // what is asked for ahead stays in the nearest cache
  for (; !nds.empty(); nds = nds.subspan(std::min(kAtOnce, nds.size()))) {
    put_some(nds.first(std::min(kAtOnce, nds.size())), information_per_m2);
  }
}

// Where the record of an ND is is found in steps, each of which waits for memory: each is taken for
// all before the next.
void RollingMatchGrid::put_some(std::span<const Nd> nds,
                                const InformationOfNd& information_per_m2) {
  for (const Nd& nd : nds) grid_.cells.prefetch(nd.key);
  found_.clear();
  for (const Nd& nd : nds) {
    found_.push_back(find_cell(grid_, nd.key));
    if (found_.back() == MatchGrid::kNone) continue;
    __builtin_prefetch(&grid_.neighbourhoods[static_cast<std::size_t>(found_.back())]);
  }
  for (std::int32_t& found : found_) {
    if (found == MatchGrid::kNone) continue;
    found = grid_.neighbourhoods[static_cast<std::size_t>(found)][0];
    if (found == MatchGrid::kNone) continue;
    __builtin_prefetch(&numbers_of_nd_[static_cast<std::size_t>(found)]);
    __builtin_prefetch(&grid_.nds[static_cast<std::size_t>(found)], 1);
  }
  constexpr std::size_t kAhead = 3;
  for (std::size_t i = 0; i < nds.size(); ++i) {
    if (i + kAhead < nds.size() && found_[i + kAhead] != MatchGrid::kNone) {
      prefetch_records(numbers_of_nd_[static_cast<std::size_t>(found_[i + kAhead])]);
    }
    const Nd& nd = nds[i];
    const MatchNd usable{nd.mean_m, information_per_m2(nd), normal_class(nd.eigenvectors.col(2))};
    if (!is_usable(usable)) {
      take_away(nd.key);
    } else if (found_[i] == MatchGrid::kNone) {
      add(nd.key, usable);
    } else {
      change(nd.key, found_[i], usable);
    }
  }
}

void RollingMatchGrid::add(const CellKey& key, const MatchNd& nd) {
  std::int32_t number = MatchGrid::kNone;
  if (!free_.empty()) {
    number = free_.back();
    free_.pop_back();
  } else {
    number = static_cast<std::int32_t>(grid_.nds.size());
    grid_.nds.emplace_back();
    numbers_of_nd_.emplace_back();
  }
  const CellNumbers numbers = numbers_around(key);
  grid_.nds[static_cast<std::size_t>(number)] = nd;
  numbers_of_nd_[static_cast<std::size_t>(number)] = numbers;
  set_lanes(key, numbers, number);
}

// Most NDs change from scan to scan, and stay where they are.
void RollingMatchGrid::change(const CellKey& key, std::int32_t number, const MatchNd& nd) {
  const CellNumbers& numbers = numbers_of_nd_[static_cast<std::size_t>(number)];
  MatchNd& record = grid_.nds[static_cast<std::size_t>(number)];
  const bool is_turned = record.normal_class != nd.normal_class;
  record = nd;
  fill_lanes(key, numbers, number);
  if (!is_turned) return;
  for (const std::uint32_t cell : numbers) {
    grid_.normal_classes[cell] = class_of(grid_, grid_.neighbourhoods[cell]);
  }
}

void RollingMatchGrid::take_away(const CellKey& key) {
  const std::int32_t number = nd_of_cell(grid_, key);
  if (number == MatchGrid::kNone) return;
  set_lanes(key, numbers_of_nd_[static_cast<std::size_t>(number)], MatchGrid::kNone);
  free_.push_back(number);
}

void RollingMatchGrid::finish() {
  if (2 * unused_count_ > grid_.cells.size()) {
    RollingMatchGrid kept(grid_.cell_m);
    for (std::size_t i = 0; i < grid_.cells.size(); ++i) {
      const std::int32_t nd = grid_.neighbourhoods[i][0];
      if (nd != MatchGrid::kNone) {
        kept.add(grid_.cells.keys()[i], grid_.nds[static_cast<std::size_t>(nd)]);
      }
    }
    *this = std::move(kept);
  }
  const std::uint64_t digests[] = {xxh3(std::as_bytes(std::span(grid_.cells.keys()))),
                                   xxh3(std::as_bytes(std::span(grid_.is_unused)))};
  grid_.cells_digest = xxh3(std::as_bytes(std::span(digests)));
}

std::int32_t find_cell(const MatchGrid& grid, const CellKey& key) {
  static_assert(MatchGrid::kNone == static_cast<std::int32_t>(CellIndex::kNone));
  const auto number = static_cast<std::int32_t>(grid.cells.find(key));
  if (grid.is_unused.empty() || number == MatchGrid::kNone) return number;
  return grid.is_unused[static_cast<std::size_t>(number)] == 0 ? number : MatchGrid::kNone;
}

std::int32_t record_of_cell(const MatchGrid& grid, const CellKey& key) {
  if (grid.columns.is_empty()) return find_cell(grid, key) + 1;
  return find_record(grid.columns.records(), key.x, key.y, key.z);
}

void prefetch_cell(const MatchGrid& grid, const CellKey& key) {
  if (grid.columns.is_empty()) return grid.cells.prefetch(key);
  __builtin_prefetch(find_column(grid.columns.records(), key.x, key.y));
}

}  // namespace sightline
