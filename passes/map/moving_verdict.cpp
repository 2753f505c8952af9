#include "passes/map/moving_verdict.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

// A voxel is judged by its own evidence first, then by that of its surroundings, both ways:
// - What stands has edges that are hit once and seen through often, by noise and because a ray
//   beside an edge goes on. A voxel next to several that stand beyond doubt is such an edge.
// - What moves leaves a dense trail of voxels, some of which hardly any ray tells of. A voxel of
//   little evidence goes with the trail that it lies in.

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

// Columns of the plane as one number, so that the neighbour of a column is a sum away.
std::int64_t column_number(std::int64_t x, std::int64_t y) {
  return x * (std::int64_t{1} << 32) + y;
}

std::int64_t column_of(const CellKey& key) {
  return column_number(floor_divide(key.x, kColumn_voxels), floor_divide(key.y, kColumn_voxels));
}

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
  return (2.0 * kSteps + 1.0 + 3.0 * kColumn_voxels) * voxel_m;
}

void mark_ground(SeenVoxels& seen) {
  std::unordered_map<std::int64_t, double> lowest_m;
  for (std::size_t v = 0; v < seen.size(); ++v) {
    const double height_m = seen.values()[v].mean_m().z();
    const auto [entry, is_new] = lowest_m.try_emplace(column_of(seen.keys()[v]), height_m);
    if (!is_new) entry->second = std::min(entry->second, height_m);
  }
  std::unordered_map<std::int64_t, double> around_m;
  for (const auto& [column, height_m] : lowest_m) {
    double least_m = height_m;
    for (int code = 0; code < 9; ++code) {
      const auto entry = lowest_m.find(column + column_number(code % 3 - 1, code / 3 - 1));
      if (entry != lowest_m.end()) least_m = std::min(least_m, entry->second);
    }
    around_m[column] = least_m;
  }
  for (std::size_t v = 0; v < seen.size(); ++v) {
    SeenVoxel& voxel = seen.values()[v];
    const double lowest_around_m = around_m.at(column_of(seen.keys()[v]));
    voxel.is_ground = voxel.mean_m().z() < lowest_around_m + kGroundThickness_m;
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
  const std::vector<std::uint8_t> trail = without_edges(seen, moved);
  std::vector<std::uint8_t> grown = trail;
  for (const auto& [v, around] : surroundings_of_trail(seen, trail)) {
    const SeenVoxel& voxel = seen.values()[v];
    const int least = voxel.is_ground ? kMovedAroundGround : kMovedAround;
    if (log_odds(voxel) > kWeakLogOdds || around.moved < least) continue;
    if (voxel.is_ground ? voxel.misses > 0 : around.moved > 2 * around.strong) grown[v] = 1;
  }
  return grown;
}

}  // namespace sightline
