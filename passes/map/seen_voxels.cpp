#include "passes/map/seen_voxels.h"

#include <algorithm>
#include <limits>
#include <map>
#include <unordered_map>
#include <vector>

#include "formats/grid/cell_blocks.h"

namespace sightline {
namespace {

// Edge of the columns of which nine make the surroundings, in voxels: wide enough for the rings of
// a sparse sensor.
constexpr std::int32_t kColumn_voxels = 3;
// Points up to here above the lowest of their surroundings are ground: kerbs and unevenness.
constexpr double kGroundThickness_m = 0.15;
// Pavements, verges and banks: up to so far above the lowest of its surroundings a surface is
// ground where nothing stands on it, this many voxels up, and where it goes on level in so many of
// the 25 places around. What moves has its upper parts above its lower ones.
constexpr double kLedge_m = 0.5;
constexpr std::int32_t kClear_voxels = 8;
constexpr int kLedgePlaces = 6;
// It is ground beyond doubt where it goes on in so many: few parts of what moves do.
constexpr int kLevelPlaces = 16;
// So many voxels of one height make ground; of each column the lowest few are looked at.
constexpr std::size_t kSupport = 3;
constexpr std::size_t kLowest = 12;
// Edge of the places of which nine have a level of ground in common, in voxels, and the height of a
// level.
constexpr std::int32_t kPlace_voxels = 15;
constexpr double kLevel_m = 0.4;
// A level is common when so many columns have it, for one of the level that most have.
constexpr double kCommonShare = 0.1;

CellKey place_of(const CellKey& key) {
  return {floor_divide(key.x, kPlace_voxels), floor_divide(key.y, kPlace_voxels), 0};
}

// How many columns of a place have a voxel at a level.
using Levels = std::map<std::int32_t, std::uint32_t>;

CellTable<Levels> levels_of_places(const SeenVoxels& seen) {
  CellTable<std::uint8_t> counted;  // columns, level by level
  CellTable<Levels> places;
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
    const CellTable<Levels> places = levels_of_places(seen);
    for (const CellKey& at : places.keys()) level_m_.insert(at, common_level_m(places, at));
  }

  // Lower edge of the level around a voxel, m.
  [[nodiscard]] double around_m(const CellKey& key) const { return *level_m_.find(place_of(key)); }

 private:
  static double common_level_m(const CellTable<Levels>& places, const CellKey& at) {
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

  CellTable<double> level_m_;
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

bool is_clear_above(const CellWindow& seen, const CellKey& key) {
  for (std::int32_t x = -1; x <= 1; ++x) {
    for (std::int32_t y = -1; y <= 1; ++y) {
      // The next voxel may hold the same surface.
      for (std::int32_t z = 2; z <= kClear_voxels; ++z) {
        if (seen.holds({key.x + x, key.y + y, key.z + z})) return false;
      }
    }
  }
  return true;
}

// Of a voxel and the two to each side, those that hold something within a voxel of its height.
int level_places_around(const CellWindow& seen, const CellKey& key) {
  int places = 0;
  for (int code = 0; code < 25; ++code) {
    const CellKey at{key.x + code % 5 - 2, key.y + code / 5 - 2, key.z};
    bool is_seen = false;
    for (std::int32_t z = -1; z <= 1 && !is_seen; ++z) {
      is_seen = seen.holds({at.x, at.y, at.z + z});
    }
    places += is_seen ? 1 : 0;
  }
  return places;
}

}  // namespace

std::int64_t column_number(std::int64_t x, std::int64_t y) {
  return x * (std::int64_t{1} << 32) + y;
}

std::int64_t column_of(const CellKey& key) {
  return column_number(floor_divide(key.x, kColumn_voxels), floor_divide(key.y, kColumn_voxels));
}

std::int32_t reach_of_ground_voxels() { return 3 * kColumn_voxels + 2 * kPlace_voxels; }

void mark_ground(SeenVoxels& seen) {
  const GroundLevels levels(seen);
  const LowVoxels low(seen, levels);
  const CellBlocks blocks(seen.keys());
  CellWindow around(blocks, {2, 2, 1}, {2, 2, kClear_voxels});
  for (std::size_t block = 0; block < blocks.size(); ++block) {
    around.move_to(block);
    for (const auto& [key, v] : blocks.cells(block)) {
      SeenVoxel& voxel = seen.values()[v];
      const double height_m = voxel.mean_m().z();
      const double level_m = levels.around_m(key);
      const double lowest_m = low.around_m(column_of(key));
      const double above_m = height_m - lowest_m;
      const bool is_among_low = height_m >= level_m - kLevel_m;
      const bool may_be_ledge = above_m < kLedge_m && is_among_low && is_clear_above(around, key);
      const int places = may_be_ledge ? level_places_around(around, key) : 0;
      voxel.is_level = places >= kLevelPlaces;
      voxel.is_ground = (above_m < kGroundThickness_m || places >= kLedgePlaces) && is_among_low;
      voxel.above_ground_m = static_cast<float>(height_m - std::min(level_m + kLevel_m, lowest_m));
    }
  }
}

}  // namespace sightline
