#include "formats/map/diff/diff_tiles.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "map_generated.h"

namespace sightline {
namespace {

using Blocks = flatbuffers::Vector<flatbuffers::Offset<schema::Block>>;

bool is_same(const schema::Digest& a, const schema::Digest& b) {
  return std::equal(a.bytes()->begin(), a.bytes()->end(), b.bytes()->begin());
}

bool is_same(const schema::Block* before, const schema::Block* after) {
  if (before == nullptr || after == nullptr) return before == after;
  return before->version() == after->version() && before->row_count() == after->row_count() &&
         is_same(*before->raw_digest(), *after->raw_digest());
}

const schema::Tile* tile_at(const MapSide& side, std::optional<std::uint32_t> tile) {
  return tile ? side.container().directory->tiles()->Get(*tile) : nullptr;
}

// Whole steps in `distance_m`, if it is a whole number of them that a key can hold.
std::optional<std::int32_t> whole_steps(double distance_m, double step_m) {
  const double steps = std::round(distance_m / step_m);
  constexpr double kMost = 0x1.0p30;
  if (!(std::abs(steps) < kMost) || steps * step_m != distance_m) return std::nullopt;
  return static_cast<std::int32_t>(steps);
}

std::map<TileKey, TilePair> tiles_by_place(const MapSide& before, const MapSide& after,
                                           const GridShift& shift) {
  std::map<TileKey, TilePair> pairs;
  for (std::uint32_t tile = 0; tile < after.tile_count(); ++tile) {
    pairs[after.tile_key(tile)].after = tile;
  }
  for (std::uint32_t tile = 0; tile < before.tile_count(); ++tile) {
    const TileKey key = before.tile_key(tile);
    const std::int64_t x = std::int64_t{key.x} + shift.tiles.x;
    const std::int64_t y = std::int64_t{key.y} + shift.tiles.y;
    pairs[{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)}].before = tile;
  }
  return pairs;
}

void compare(const MapSide& before, const MapSide& after, TilePair& pair) {
  if (!pair.before || !pair.after) return;
  const auto same_layer = [&](std::string_view name) {
    return is_same(find_layer(before.container(), *pair.before, name),
                   find_layer(after.container(), *pair.after, name));
  };
  pair.has_same_digest =
      is_same(*tile_at(before, pair.before)->digest(), *tile_at(after, pair.after)->digest());
  pair.has_same_nds = same_layer(kNdtLayer);
  pair.has_same_sites = same_layer(kRangeLayer);
}

void count_blocks(const Blocks* before, const Blocks* after,
                  std::map<std::string, BlockDiff>& counts) {
  std::map<std::string, std::pair<const schema::Block*, const schema::Block*>> names;
  if (before != nullptr) {
    for (const schema::Block* block : *before) names[block->name()->str()].first = block;
  }
  if (after != nullptr) {
    for (const schema::Block* block : *after) names[block->name()->str()].second = block;
  }
  for (const auto& [name, blocks] : names) {
    if (is_derived(name)) continue;  // follows from the others
    BlockDiff& count = counts[name];
    count.name = name;
    count.is_required |= (blocks.second != nullptr ? blocks.second : blocks.first)->is_required();
    if (blocks.first == nullptr) {
      ++count.added;
    } else if (blocks.second == nullptr) {
      ++count.removed;
    } else {
      ++(is_same(blocks.first, blocks.second) ? count.same : count.changed);
    }
  }
}

}  // namespace

std::optional<GridShift> grid_shift(const CompiledMap& before, const CompiledMap& after) {
  if (before.ndt.cell_m != after.ndt.cell_m || before.ndt.tile_m != after.ndt.tile_m) return {};
  const Eigen::Vector3d shift_m = before.ndt.frame.origin_world_m - after.ndt.frame.origin_world_m;
  const std::optional<std::int32_t> tiles_x = whole_steps(shift_m.x(), after.ndt.tile_m);
  const std::optional<std::int32_t> tiles_y = whole_steps(shift_m.y(), after.ndt.tile_m);
  const std::optional<std::int32_t> cells_x = whole_steps(shift_m.x(), after.ndt.cell_m);
  const std::optional<std::int32_t> cells_y = whole_steps(shift_m.y(), after.ndt.cell_m);
  const std::optional<std::int32_t> cells_z = whole_steps(shift_m.z(), after.ndt.cell_m);
  if (!tiles_x || !tiles_y || !cells_x || !cells_y || !cells_z) return {};
  return GridShift{{*tiles_x, *tiles_y}, {*cells_x, *cells_y, *cells_z}};
}

std::vector<TilePair> pair_tiles(const MapSide& before, const MapSide& after,
                                 const std::optional<GridShift>& shift) {
  std::vector<TilePair> pairs;
  if (!shift) {
    for (std::uint32_t tile = 0; tile < after.tile_count(); ++tile) {
      pairs.emplace_back().after = tile;
    }
    for (std::uint32_t tile = 0; tile < before.tile_count(); ++tile) {
      pairs.emplace_back().before = tile;
    }
    return pairs;
  }
  for (auto& [key, pair] : tiles_by_place(before, after, *shift)) {
    compare(before, after, pair);
    pairs.push_back(pair);
  }
  return pairs;
}

std::vector<BlockDiff> diff_blocks(const MapSide& before, const MapSide& after,
                                   const std::vector<TilePair>& tiles) {
  std::map<std::string, BlockDiff> counts;
  for (const TilePair& pair : tiles) {
    const schema::Tile* old_tile = tile_at(before, pair.before);
    const schema::Tile* new_tile = tile_at(after, pair.after);
    count_blocks(old_tile == nullptr ? nullptr : old_tile->layers(),
                 new_tile == nullptr ? nullptr : new_tile->layers(), counts);
  }
  count_blocks(before.container().directory->sections(), after.container().directory->sections(),
               counts);
  std::vector<BlockDiff> blocks;
  for (auto& [name, count] : counts) blocks.push_back(count);
  return blocks;
}

}  // namespace sightline
