#include "passes/map/moving_verdict.h"

#include <unordered_map>

#include "formats/grid/cell_blocks.h"
#include "passes/map/seen_voxels.h"

// A voxel is judged by its own evidence first, then by that of its surroundings, both ways:
// - What stands has edges that are hit once and seen through often, by noise and because a ray
//   beside an edge goes on. A voxel next to several that stand beyond doubt is such an edge.
// - What moves leaves a dense trail of voxels, some of which are crossed by hardly any ray. A voxel
//   of little evidence goes with its trail.
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

// Calls visit(voxel, another around it) for each voxel that is asked about, block by block.
template <class IsAsked, class Visit>
void visit_around(const CellBlocks& blocks, const IsAsked& is_asked, const Visit& visit) {
  CellWindow around(blocks, {kSteps, kSteps, kSteps}, {kSteps, kSteps, kSteps});
  for (std::size_t block = 0; block < blocks.size(); ++block) {
    bool is_there = false;
    for (const auto& [key, v] : blocks.cells(block)) {
      if (!is_asked(v)) continue;
      if (!is_there) around.move_to(block);
      is_there = true;
      for (int x = -kSteps; x <= kSteps; ++x) {
        for (int y = -kSteps; y <= kSteps; ++y) {
          for (int z = -kSteps; z <= kSteps; ++z) {
            const std::uint32_t near = around.number_of({key.x + x, key.y + y, key.z + z});
            if (near != CellWindow::kNone && near != v) visit(v, near);
          }
        }
      }
    }
  }
}

// Of those voxels that are asked about.
template <class IsAsked>
std::vector<Surroundings> surroundings(const SeenVoxels& seen, const CellBlocks& blocks,
                                       const std::vector<std::uint8_t>& moved,
                                       const IsAsked& is_asked) {
  std::vector<Surroundings> around(seen.size());
  visit_around(blocks, is_asked, [&](std::uint32_t v, std::uint32_t near) {
    const SeenVoxel& voxel = seen.values()[near];
    around[v].moved += moved[near];
    around[v].strong += !voxel.is_ground && log_odds(voxel) >= kStrongLogOdds ? 1 : 0;
  });
  return around;
}

std::vector<std::uint8_t> without_edges(const SeenVoxels& seen, const CellBlocks& blocks,
                                        const std::vector<std::uint8_t>& moved) {
  const auto may_be_edge = [&](std::uint32_t v) {
    return moved[v] != 0 && !seen.values()[v].is_ground;
  };
  const std::vector<Surroundings> around = surroundings(seen, blocks, moved, may_be_edge);
  std::vector<std::uint8_t> kept = moved;
  for (std::uint32_t v = 0; v < moved.size(); ++v) {
    if (!may_be_edge(v)) continue;
    if (around[v].strong >= kStrongAround && 2 * around[v].strong > around[v].moved) kept[v] = 0;
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

// One a voxel: 1 beside the trail where it did not move itself.
std::vector<std::uint8_t> beside_trail(const CellBlocks& blocks,
                                       const std::vector<std::uint8_t>& trail) {
  std::vector<std::uint8_t> beside(trail.size(), 0);
  visit_around(
      blocks, [&](std::uint32_t v) { return trail[v] != 0; },
      [&](std::uint32_t, std::uint32_t near) { beside[near] = trail[near] == 0 ? 1 : 0; });
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

std::vector<std::uint8_t> judge(const SeenVoxels& seen) {
  const std::size_t count = seen.size();
  std::vector<std::uint8_t> moved(count, 0);
  for (std::size_t v = 0; v < count; ++v) moved[v] = is_contradicted(seen.values()[v]) ? 1 : 0;
  const CellBlocks blocks(seen.keys());
  const std::vector<std::uint8_t> trail = with_footing(seen, without_edges(seen, blocks, moved));
  const std::vector<std::uint8_t> beside = beside_trail(blocks, trail);
  const std::vector<Surroundings> around =
      surroundings(seen, blocks, trail, [&](std::uint32_t v) { return beside[v] != 0; });
  std::vector<std::uint8_t> grown = trail;
  for (std::size_t v = 0; v < count; ++v) {
    if (beside[v] == 0) continue;
    const SeenVoxel& voxel = seen.values()[v];
    const int least = voxel.is_ground ? kMovedAroundGround : kMovedAround;
    if (log_odds(voxel) > kWeakLogOdds || around[v].moved < least) continue;
    if (goes_with_trail(voxel, around[v])) grown[v] = 1;
  }
  return with_footing(seen, grown);
}

}  // namespace sightline
