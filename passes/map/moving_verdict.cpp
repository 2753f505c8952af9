#include "passes/map/moving_verdict.h"

#include <map>
#include <unordered_map>

#include "passes/map/voxel_ground.h"

// A voxel is judged by its own evidence first, then by that of its surroundings, both ways:
// - What stands has edges that are hit once and seen through often, by noise and because a ray
//   beside an edge goes on. A voxel next to several that stand beyond doubt is such an edge.
// - What moves leaves a dense trail of voxels, some of which hardly any ray tells of. A voxel of
//   little evidence goes with the trail that it lies in.
// - What moves on a street stands on it: edges of facades, wires and foliage that rays go
//   through do not, and stay.

namespace sightline {
namespace {

// OctoMap's sensor model: P(occupied) after a hit is 0.7, after a miss 0.4.
constexpr double kHitLogOdds = 0.8472978603872034;
constexpr double kMissLogOdds = -0.4054651081081644;
// Surroundings by which a voxel is judged: two voxels to each side, 124 in all.
constexpr int kSteps = 2;
// So many around that stand beyond doubt make an edge, unless twice as many around moved.
constexpr int kStrongAround = 2;
// A voxel with no more evidence for standing than this goes with its surroundings: two hits and no
// miss.
constexpr double kWeakLogOdds = 2.0 * kHitLogOdds;
constexpr int kMovedAround = 4;
// Ground must have been looked through at least once, but then fewer suffice.
constexpr int kMovedAroundGround = 2;

// Traffic is no taller. Of what is higher than kFooting_m a voxel goes only where, in each band of
// height from kLowestFooting_m (below is free space under a lorry) up to it, two voxels near moved.
constexpr double kTallest_m = 4.5;
constexpr double kFooting_m = 2.0;
constexpr double kLowestFooting_m = 1.0;
constexpr double kBand_m = 0.5;

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

// Which bands of height above the ground moved, one bit each: in one voxel, and in two or more. A
// lorry fills its bands; what people walk under has single voxels that are looked through.
struct MovedBands {
  std::uint32_t once = 0;
  std::uint32_t again = 0;
  void add(const MovedBands& other) {
    again |= other.again | (once & other.once);
    once |= other.once;
  }
};
using Bands = std::unordered_map<std::int64_t, MovedBands>;  // by column

int band_of(double above_m) { return static_cast<int>(above_m / kBand_m); }

Bands moved_bands(const SeenVoxels& seen, const std::vector<std::uint8_t>& moved) {
  Bands bands;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const double above_m = seen.values()[v].above_ground_m;
    if (moved[v] == 0 || above_m < 0.0 || above_m > kTallest_m) continue;
    bands[column_of(seen.keys()[v])].add({1U << band_of(above_m), 0});
  }
  return bands;
}

bool has_footing(const Bands& bands, std::int64_t column, double above_m) {
  if (above_m > kTallest_m) return false;
  MovedBands around;
  for (int code = 0; code < 9; ++code) {
    const auto entry = bands.find(column + column_number(code % 3 - 1, code / 3 - 1));
    if (entry != bands.end()) around.add(entry->second);
  }
  for (int band = band_of(kLowestFooting_m); band < band_of(above_m); ++band) {
    if ((around.again >> band & 1U) == 0) return false;
  }
  return true;
}

// Without what hangs in the air: what moves on a street stands on it. A house that is gone since an
// earlier drive is no traffic.
std::vector<std::uint8_t> with_footing(const SeenVoxels& seen,
                                       const std::vector<std::uint8_t>& moved) {
  const Bands bands = moved_bands(seen, moved);
  std::vector<std::uint8_t> kept = moved;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const double above_m = seen.values()[v].above_ground_m;
    if (moved[v] == 0 || above_m <= kFooting_m || seen.values()[v].has_changed) continue;
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

// Grass, and poses off by a hand's breadth, let some rays pass below level ground: what contradicts
// it must outweigh one hit more than there was.
bool is_contradicted(const SeenVoxel& voxel) {
  return log_odds(voxel) < (voxel.is_level ? -kHitLogOdds : 0.0);
}

// Whether a voxel of little evidence is of the trail that it lies in.
bool goes_with_trail(const SeenVoxel& voxel, const Surroundings& around) {
  if (voxel.is_level) return log_odds(voxel) < 0.0;
  if (voxel.is_ground) return voxel.misses > 0;
  return around.moved > 2 * around.strong;
}

}  // namespace

double log_odds(std::uint32_t hits, std::uint32_t misses) {
  return hits * kHitLogOdds + misses * kMissLogOdds;
}

double log_odds(const SeenVoxel& voxel) {
  return voxel.of_drives_log_odds.value_or(log_odds(voxel.hits, voxel.misses));
}

bool stands_anyway(const SeenVoxel& voxel, std::size_t scan_count) {
  SeenVoxel worst = voxel;
  worst.misses = static_cast<std::uint32_t>(scan_count);
  return log_odds(worst) >= kStrongLogOdds;
}

// Two rounds of surroundings, and the columns that tell ground around those.
double reach_of_judgement_m(double voxel_m) {
  return (2.0 * kSteps + 1.0 + reach_of_ground_voxels()) * voxel_m;
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
  for (std::size_t v = 0; v < count; ++v) moved[v] = is_contradicted(seen.values()[v]) ? 1 : 0;
  std::vector<std::uint8_t> trail = without_edges(seen, moved);
  trail = with_footing(seen, trail);
  std::vector<std::uint8_t> grown = trail;
  for (const auto& [v, around] : surroundings_of_trail(seen, trail)) {
    const SeenVoxel& voxel = seen.values()[v];
    const int least = voxel.is_ground ? kMovedAroundGround : kMovedAround;
    if (log_odds(voxel) > kWeakLogOdds || around.moved < least) continue;
    if (goes_with_trail(voxel, around)) grown[v] = 1;
  }
  return with_footing(seen, grown);
}

}  // namespace sightline
