#include "passes/map/moving_verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

// A voxel is judged by its own evidence first, then by that of its surroundings, both ways:
// - What stands has edges that are hit once and seen through often, by noise and because a ray
//   beside an edge goes on. A voxel next to several that stand beyond doubt is such an edge.
// - What moves leaves a dense trail of voxels, some of which hardly any ray tells of. A voxel of
//   little evidence goes with the trail that it lies in.
// - What moves on a street stands on it: edges of facades, wires and foliage that rays go through
// do
//   not, and stay.

namespace sightline {
namespace {

// OctoMap's sensor model: P(occupied) after a hit is 0.7, after a miss 0.4.
constexpr double kHitLogOdds = 0.8472978603872034;
constexpr double kMissLogOdds = -0.4054651081081644;
// Edge of the columns of which nine make the surroundings, in voxels: wide enough for the rings of
// a sparse sensor.
constexpr std::int32_t kColumn_voxels = 3;
// Points up to here above the lowest of their surroundings are ground: kerbs and unevenness.
constexpr double kGroundThickness_m = 0.15;
// So many voxels of one height make ground; of each column the lowest few are looked at.
constexpr std::size_t kSupport = 3;
constexpr std::size_t kLowest = 12;
// Edge of the places of which nine have a level of ground in common, in voxels, and the height of a
// level.
constexpr std::int32_t kPlace_voxels = 15;
constexpr double kLevel_m = 0.4;
// A level is common when so many columns have it, for one of the level that most have.
constexpr double kCommonShare = 0.1;
// Surroundings by which a voxel is judged: two voxels to each side, 124 in all.
constexpr int kSteps = 2;
// OctoMap's clamping threshold, P(occupied) = 0.97: what stands beyond doubt.
constexpr double kStrongLogOdds = 3.5;
// So many around that stand beyond doubt make an edge, unless twice as many around moved.
constexpr int kStrongAround = 2;
// A voxel with no more evidence for standing than this goes with its surroundings: two hits and no
// miss.
constexpr double kWeakLogOdds = 2.0 * kHitLogOdds;
constexpr int kMovedAround = 4;
// Ground must have been looked through at least once, but then fewer suffice.
constexpr int kMovedAroundGround = 2;

// Traffic is no taller. Of what is higher than kFooting_m a voxel goes only where, in each band of
// height from kLowestFooting_m (below is free space under a lorry) up to it, something near moved.
constexpr double kTallest_m = 4.5;
constexpr double kFooting_m = 2.0;
constexpr double kLowestFooting_m = 1.0;
constexpr double kBand_m = 0.5;

// Columns of the plane as one number, so that the neighbour of a column is a sum away.
std::int64_t column_number(std::int64_t x, std::int64_t y) {
  return x * (std::int64_t{1} << 32) + y;
}

std::int64_t column_of(const CellKey& key) {
  return column_number(floor_divide(key.x, kColumn_voxels), floor_divide(key.y, kColumn_voxels));
}

CellKey place_of(const CellKey& key) {
  return {floor_divide(key.x, kPlace_voxels), floor_divide(key.y, kPlace_voxels), 0};
}

// How many columns of a place have a voxel at a level.
using Levels = std::map<std::int32_t, std::uint32_t>;

FlatCellMap<Levels> levels_of_places(const SeenVoxels& seen) {
  FlatCellMap<std::uint8_t> counted;  // columns, level by level
  FlatCellMap<Levels> places;
  for (std::size_t v = 0; v < seen.size(); ++v) {
    const CellKey& key = seen.keys()[v];
    const std::int32_t level = floor_to_int(seen.values()[v].mean_m().z() / kLevel_m);
    const CellKey column{floor_divide(key.x, kColumn_voxels), floor_divide(key.y, kColumn_voxels),
                         level};
    if (!counted.insert(column).is_new) continue;
    const std::uint32_t place = places.insert(place_of(key)).number;
    ++places.values()[place][level];
  }
  return places;
}

// The lowest level that many columns around a place have in common.
class GroundLevels {
 public:
  explicit GroundLevels(const SeenVoxels& seen) {
    const FlatCellMap<Levels> places = levels_of_places(seen);
    for (const CellKey& at : places.keys()) level_m_.insert(at, common_level_m(places, at));
  }

  // Lower edge of the level around a voxel, m.
  [[nodiscard]] double around_m(const CellKey& key) const { return *level_m_.find(place_of(key)); }

 private:
  static double common_level_m(const FlatCellMap<Levels>& places, const CellKey& at) {
    Levels around;
    std::uint32_t most = 0;
    for (int code = 0; code < 9; ++code) {
      const Levels* near = places.find({at.x + code % 3 - 1, at.y + code / 3 - 1, 0});
      if (near == nullptr) continue;
      for (const auto& [level, count] : *near) most = std::max(most, around[level] += count);
    }
    for (const auto& [level, count] : around) {
      if (count >= kCommonShare * most) return kLevel_m * level;
    }
    return kLevel_m * around.begin()->first;
  }

  FlatCellMap<double> level_m_;
};

// The ground of each column's surroundings.
class LowVoxels {
 public:
  LowVoxels(const SeenVoxels& seen, const GroundLevels& levels) {
    for (std::size_t v = 0; v < seen.size(); ++v) {
      const double height_m = seen.values()[v].mean_m().z();
      if (height_m < levels.around_m(seen.keys()[v]) - kLevel_m) continue;
      heights_m_[column_of(seen.keys()[v])].push_back(height_m);
    }
    for (auto& [column, heights_m] : heights_m_) {
      std::ranges::sort(heights_m);
      if (heights_m.size() > kLowest) heights_m.resize(kLowest);
    }
    for (const auto& [column, heights_m] : heights_m_) ground_m_[column] = ground_around_m(column);
  }

  // Infinite where there is nothing.
  [[nodiscard]] double around_m(std::int64_t column) const {
    const auto entry = ground_m_.find(column);
    return entry == ground_m_.end() ? std::numeric_limits<double>::infinity() : entry->second;
  }

 private:
  // The lowest voxel that is one of several of a height; where there is none, the lowest.
  [[nodiscard]] double ground_around_m(std::int64_t column) const {
    std::vector<double> around_m;
    for (int code = 0; code < 9; ++code) {
      const auto entry = heights_m_.find(column + column_number(code % 3 - 1, code / 3 - 1));
      if (entry == heights_m_.end()) continue;
      around_m.insert(around_m.end(), entry->second.begin(), entry->second.end());
    }
    std::ranges::sort(around_m);
    for (std::size_t i = 0; i + kSupport <= around_m.size(); ++i) {
      if (around_m[i + kSupport - 1] < around_m[i] + kGroundThickness_m) return around_m[i];
    }
    return around_m.front();
  }

  std::unordered_map<std::int64_t, std::vector<double>> heights_m_;  // the lowest few, ascending
  std::unordered_map<std::int64_t, double> ground_m_;
};

// How many voxels around one moved, and how many above the ground stand beyond doubt.
struct Surroundings {
  int moved = 0;
  int strong = 0;
};

Surroundings surroundings(const SeenVoxels& seen, const std::vector<std::uint8_t>& moved,
                          std::size_t v) {
  Surroundings around;
  for (const std::uint32_t near : neighbours(seen, v, kSteps)) {
    const SeenVoxel& voxel = seen.values()[near];
    around.moved += moved[near];
    around.strong += !voxel.is_ground && log_odds(voxel) >= kStrongLogOdds ? 1 : 0;
  }
  return around;
}

std::vector<std::uint8_t> without_edges(const SeenVoxels& seen,
                                        const std::vector<std::uint8_t>& moved) {
  std::vector<std::uint8_t> kept = moved;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    if (moved[v] == 0 || seen.values()[v].is_ground) continue;
    const Surroundings around = surroundings(seen, moved, v);
    if (around.strong >= kStrongAround && 2 * around.strong > around.moved) kept[v] = 0;
  }
  return kept;
}

// Which bands of height above the ground moved, one bit each, by column.
using Bands = std::unordered_map<std::int64_t, std::uint32_t>;

int band_of(double above_m) { return static_cast<int>(above_m / kBand_m); }

Bands moved_bands(const SeenVoxels& seen, const std::vector<std::uint8_t>& moved) {
  Bands bands;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const double above_m = seen.values()[v].above_ground_m;
    if (moved[v] == 0 || above_m < 0.0 || above_m > kTallest_m) continue;
    bands[column_of(seen.keys()[v])] |= 1U << band_of(above_m);
  }
  return bands;
}

bool has_footing(const Bands& bands, std::int64_t column, double above_m) {
  if (above_m > kTallest_m) return false;
  std::uint32_t around = 0;
  for (int code = 0; code < 9; ++code) {
    const auto entry = bands.find(column + column_number(code % 3 - 1, code / 3 - 1));
    if (entry != bands.end()) around |= entry->second;
  }
  for (int band = band_of(kLowestFooting_m); band < band_of(above_m); ++band) {
    if ((around >> band & 1U) == 0) return false;
  }
  return true;
}

// Without what hangs in the air: what moves on a street stands on it.
std::vector<std::uint8_t> with_footing(const SeenVoxels& seen,
                                       const std::vector<std::uint8_t>& moved) {
  const Bands bands = moved_bands(seen, moved);
  std::vector<std::uint8_t> kept = moved;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const double above_m = seen.values()[v].above_ground_m;
    if (moved[v] == 0 || above_m <= kFooting_m) continue;
    if (!has_footing(bands, column_of(seen.keys()[v]), above_m)) kept[v] = 0;
  }
  return kept;
}

// Of the voxels beside the trail that did not move themselves, ascending.
std::map<std::uint32_t, Surroundings> surroundings_of_trail(
    const SeenVoxels& seen, const std::vector<std::uint8_t>& trail) {
  std::map<std::uint32_t, Surroundings> beside;
  for (std::size_t v = 0; v < trail.size(); ++v) {
    if (trail[v] == 0) continue;
    for (const std::uint32_t near : neighbours(seen, v, kSteps)) {
      if (trail[near] == 0) beside.try_emplace(near);
    }
  }
  for (auto& [v, around] : beside) around = surroundings(seen, trail, v);
  return beside;
}

}  // namespace

double log_odds(const SeenVoxel& voxel) {
  return voxel.hits * kHitLogOdds + voxel.misses * kMissLogOdds;
}

bool stands_anyway(const SeenVoxel& voxel, std::size_t scan_count) {
  SeenVoxel worst = voxel;
  worst.misses = static_cast<std::uint32_t>(scan_count);
  return log_odds(worst) >= kStrongLogOdds;
}

// Two rounds of surroundings, and the columns that tell ground around those.
double reach_of_judgement_m(double voxel_m) {
  return (2.0 * kSteps + 1.0 + 3.0 * kColumn_voxels + 2.0 * kPlace_voxels) * voxel_m;
}

void mark_ground(SeenVoxels& seen) {
  const GroundLevels levels(seen);
  const LowVoxels low(seen, levels);
  for (std::size_t v = 0; v < seen.size(); ++v) {
    SeenVoxel& voxel = seen.values()[v];
    const double height_m = voxel.mean_m().z();
    const double level_m = levels.around_m(seen.keys()[v]);
    const double lowest_m = low.around_m(column_of(seen.keys()[v]));
    const double above_m = height_m - lowest_m;
    voxel.is_ground = above_m < kGroundThickness_m && height_m >= level_m - kLevel_m;
    voxel.above_ground_m = static_cast<float>(height_m - std::min(level_m + kLevel_m, lowest_m));
  }
}

std::vector<std::uint32_t> neighbours(const SeenVoxels& seen, std::size_t v, int steps) {
  const CellKey key = seen.keys()[v];
  std::vector<std::uint32_t> found;
  for (int x = -steps; x <= steps; ++x) {
    for (int y = -steps; y <= steps; ++y) {
      for (int z = -steps; z <= steps; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const std::uint32_t near = seen.number_of({key.x + x, key.y + y, key.z + z});
        if (near != SeenVoxels::kNone) found.push_back(near);
      }
    }
  }
  return found;
}

std::vector<std::uint8_t> judge(const SeenVoxels& seen) {
  const std::size_t count = seen.size();
  std::vector<std::uint8_t> moved(count, 0);
  for (std::size_t v = 0; v < count; ++v) moved[v] = log_odds(seen.values()[v]) < 0.0 ? 1 : 0;
  std::vector<std::uint8_t> trail = without_edges(seen, moved);
  trail = with_footing(seen, trail);
  std::vector<std::uint8_t> grown = trail;
  for (const auto& [v, around] : surroundings_of_trail(seen, trail)) {
    const SeenVoxel& voxel = seen.values()[v];
    const int least = voxel.is_ground ? kMovedAroundGround : kMovedAround;
    if (log_odds(voxel) > kWeakLogOdds || around.moved < least) continue;
    if (voxel.is_ground ? voxel.misses > 0 : around.moved > 2 * around.strong) grown[v] = 1;
  }
  return with_footing(seen, grown);
}

}  // namespace sightline
