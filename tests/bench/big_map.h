#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// A made-up map of any size for benchmarks: rows of tiles, each crossed by a street with a site
// every metre, NDs in random cells. Its numbers pack about as badly as those of real maps.

namespace sightline {

inline constexpr int kBigMapTilesPerMib = 12;

struct BigMapOptions {
  std::uint64_t seed = 1;
  int tile_count = 64;  // 1 to 2^20; kBigMapTilesPerMib make about one MiB of file
  // Of the tiles, the share where the map differs from the one of the same seed without changes,
  // all of them neighbours. There one ND in twenty moved, one gave way to another, and ranges rose.
  double changed_share = 0.0;
};

// The file of a map that passes every check. Takes about 2.5 times the file's size of memory.
std::vector<std::byte> big_map(const BigMapOptions& options);

}  // namespace sightline
