#include "passes/matching/look_cutter.h"

#include <algorithm>
#include <array>
#include <bit>

#include "formats/base/check.h"
#include "formats/grid/cell_key.h"

// Only the returns that the stride touches are read, each fetched long before it is needed, since a
// scan is larger than the caches. The few hundred points that are left stay in the nearest cache.

namespace sightline {
namespace {

// A number from all bits of another (Murmur3's finalizer): uniform and the same everywhere.
std::uint32_t scrambled(std::uint32_t number) {
  number ^= number >> 16;
  number *= 0x85ebca6bU;
  number ^= number >> 13;
  number *= 0xc2b2ae35U;
  return number ^ number >> 16;
}

// Never 0, and different for voxels less than 2^20 from the sensor.
std::uint64_t voxel_of(const Eigen::Vector3d& point_m, double leaf_m) {
  const CellKey key = cell_key(point_m, leaf_m);
  const auto bits = [](std::int32_t value) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value + (1 << 20)));
  };
  return bits(key.x) << 42 | bits(key.y) << 21 | bits(key.z) | std::uint64_t{1} << 63;
}

// Points nearer than this and farther ones are taken in turn.
constexpr double kNear_m = 15.0;
constexpr std::size_t kBins = 2 * (kNormalClasses + 1);
constexpr std::size_t kCandidatesPerPoint = 4;

// How many each group gives when they take turns until so many are taken or none is left. Of those
// with no ND near, which come last, none is: they would not score.
std::array<std::size_t, kBins> turns_of(const std::array<std::size_t, kBins>& sizes,
                                        std::size_t point_count) {
  std::array<std::size_t, kBins> quotas{};
  std::size_t left = point_count;
  for (bool is_any = true; left > 0 && is_any;) {
    is_any = false;
    for (std::size_t bin = 0; bin < 2 * kNormalClasses && left > 0; ++bin) {
      if (quotas[bin] == sizes[bin]) continue;
      ++quotas[bin];
      --left;
      is_any = true;
    }
  }
  return quotas;
}

}  // namespace

double look_stride(const Look& look, std::size_t count) {
  if (look.return_count == 0) return 1.0;
  return even_stride(static_cast<double>(count) / look.return_count);
}

void LookCutter::keep_first_of_voxels() {
  const std::size_t size = std::bit_ceil(std::max<std::size_t>(2 * count_, 64));
  if (slots_.size() < size) slots_.resize(size);
  std::fill_n(slots_.begin(), size, 0);
  const int shift = 64 - std::countr_zero(size);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Eigen::Vector3d point_m = points_m_[i];
    const std::uint64_t voxel = voxel_of(point_m, leaf_m_);
    std::size_t slot = (voxel * 0x9e3779b97f4a7c15ULL) >> shift;
    while (slots_[slot] != 0 && slots_[slot] != voxel) slot = (slot + 1) & (size - 1);
    points_m_[kept] = point_m;
    kept += slots_[slot] == 0 ? 1 : 0;
    slots_[slot] = voxel;
  }
  count_ = kept;
}

std::span<const Eigen::Vector3d> LookCutter::candidates(std::span<const Eigen::Vector3d> points_m,
                                                        const Look& look) {
  SIGHTLINE_CHECK(!takes_every_return(look) && points_m.size() < (std::size_t{1} << 31));
  constexpr std::size_t kAhead = 24;
  const double range2_m2 = look.range_m * look.range_m;
  // r^2 / R^2 as often as a number of 32 bits is below it.
  const double odds_per_m2 =
      look.even_beyond_m > 0.0 ? 0x1.0p32 / (look.even_beyond_m * look.even_beyond_m) : 0.0;
  // Fixed point: the same returns on every machine, and no conversion a return.
  const auto step = static_cast<std::uint64_t>(look_stride(look, points_m.size()) * 0x1.0p32);
  const std::uint64_t end = static_cast<std::uint64_t>(points_m.size()) << 32;
  points_m_.resize(std::max(points_m_.size(), end / step + 2));
  std::size_t count = 0;
  for (std::uint64_t place = 0; place < end; place += step) {
    const std::uint64_t ahead = std::min(place + kAhead * step, end - 1) >> 32;
    __builtin_prefetch(points_m[ahead].data());
    __builtin_prefetch(points_m[ahead].data() + 2);
    const Eigen::Vector3d& point_m = points_m[place >> 32];
    const double r2_m2 = point_m.squaredNorm();
    const bool is_kept = odds_per_m2 == 0.0 ||
                         static_cast<double>(scrambled(static_cast<std::uint32_t>(place >> 32))) <
                             r2_m2 * odds_per_m2;
    points_m_[count] = point_m;  // without a branch: which are kept is as good as random
    count += r2_m2 <= range2_m2 && is_kept ? 1 : 0;
  }
  count_ = count;
  keep_first_of_voxels();
  return std::span(points_m_).first(count_);
}

void LookCutter::keep_spread(std::size_t point_count) {
  if (count_ <= point_count) return;
  for (std::size_t i = 0; i < point_count; ++i) points_m_[i] = points_m_[i * count_ / point_count];
  count_ = point_count;
}

// The direction and distance of each point, and the cell of the map that it lies in.
void LookCutter::classify(const MatchGrid& grid, const Pose& T_map_lidar) {
  bins_.resize(std::max(bins_.size(), count_));
  keys_.resize(std::max(keys_.size(), count_));
  records_.resize(std::max(records_.size(), count_));
  for (std::size_t i = 0; i < count_; ++i) {
    const Eigen::Vector3d p_map_m = T_map_lidar * points_m_[i];
    keys_[i] = cell_key(p_map_m, grid.cell_m);
    prefetch_cell(grid, keys_[i]);
  }
  for (std::size_t i = 0; i < count_; ++i) {
    records_[i] = static_cast<std::uint32_t>(record_of_cell(grid, keys_[i]));
    if (records_[i] != 0) __builtin_prefetch(&grid.normal_classes[records_[i] - 1]);
  }
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t direction =
        records_[i] == 0 ? kNormalClasses : grid.normal_classes[records_[i] - 1];
    const bool is_far = points_m_[i].squaredNorm() > kNear_m * kNear_m;
    bins_[i] = static_cast<std::uint8_t>(2 * direction + (is_far ? 1 : 0));
  }
}

void LookCutter::take_by_normals(const Localizer& localizer, const Pose& T_map_lidar) {
  const MatchGrid& grid = *localizer.levels.back().grid;
  classify(grid, T_map_lidar);
  std::array<std::size_t, kBins> sizes{};
  for (std::size_t i = 0; i < count_; ++i) ++sizes[bins_[i]];
  const std::array<std::size_t, kBins> quotas = turns_of(sizes, most_);
  std::array<std::size_t, kBins> met{};
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t bin = bins_[i];
    const std::size_t number = met[bin]++;
    if ((number + 1) * quotas[bin] / sizes[bin] == number * quotas[bin] / sizes[bin]) continue;
    taken_m_.push_back(points_m_[i]);
    for (const Localizer::Level& level : localizer.levels) {
      const PackedRecords& records = level.grid->records;
      if (level.grid->cells_digest == grid.cells_digest) {
        fetch_record(records.floats(), records.places[records_[i]]);
      }
    }
  }
}

void LookCutter::prepare(const Scan& scan, const Look& look) {
  candidates(scan.points_m, look);
  most_ = look.point_count > 0 ? look.point_count : count_;
  is_by_normals_ = look.is_by_normals;
  keep_spread(is_by_normals_ ? kCandidatesPerPoint * most_ : most_);
}

void LookCutter::finish(const Localizer& localizer, const SensorProfile& sensor,
                        const Pose& T_map_start, ScanForMatch& cut) {
  taken_m_.clear();
  if (is_by_normals_) {
    take_by_normals(localizer, T_map_start * sensor.T_vehicle_lidar);
  } else {
    taken_m_.assign(points_m_.begin(), points_m_.begin() + static_cast<std::ptrdiff_t>(count_));
  }
  for (Eigen::Vector3d& point_m : taken_m_) point_m = sensor.T_vehicle_lidar * point_m;
  fill_scan_for_match(taken_m_, lead_stride(localizer, taken_m_.size()), cut);
}

void LookCutter::cut(const Localizer& localizer, const Scan& scan, const SensorProfile& sensor,
                     const Look& look, const Pose& T_map_start, ScanForMatch& cut) {
  if (takes_every_return(look)) {
    cut = make_scan_for_match(localizer, dense_, scan, sensor, {look.range_m, leaf_m_, true});
    return;
  }
  prepare(scan, look);
  finish(localizer, sensor, T_map_start, cut);
}

void LookMatcher::take(const Scan& scan, const Look& look) {
  look_ = look;
  climbs_.clear();
  if (!takes_every_return(look)) {
    cutter_.prepare(scan, look);
    if (!look.is_by_normals) {
      cutter_.finish(*sampled_, matching_.sensor, Pose::Identity(), cut_);
    }
    return;
  }
  cut_ = make_scan_for_match(*own_, near_cutter_, scan, matching_.sensor,
                             {look.range_m, matching_.leaf_m, matching_.takes_every_return});
}

MatchResult LookMatcher::match(const Pose& T_map_start, double search_m) {
  SharedClimbs* const shared = matching_.shares_climbs && !look_.is_by_normals ? &climbs_ : nullptr;
  if (takes_every_return(look_)) {
    return localize(*own_, cut_, T_map_start, {.search_m = search_m}, shared);
  }
  if (look_.is_by_normals) {
    cutter_.finish(*sampled_, matching_.sensor, T_map_start, cut_);
  }
  const MatchOptions options{.stop_step_m = kSampleStop_m, .search_m = search_m};
  return look_.mode == LookMode::kSettle ? settle(*sampled_, cut_, T_map_start, options)
                                         : localize(*sampled_, cut_, T_map_start, options, shared);
}

MatchResult LookMatcher::score(const Pose& T_map_vehicle) {
  const bool is_sample = !takes_every_return(look_);
  if (is_sample && look_.is_by_normals) {
    cutter_.finish(*sampled_, matching_.sensor, T_map_vehicle, cut_);
  }
  MatchResult result =
      settle(is_sample ? *sampled_ : *own_, cut_, T_map_vehicle, {.max_iterations = 1});
  result.T_map_sensor = T_map_vehicle;  // without the one step
  return result;
}

}  // namespace sightline
