#pragma once

#include <cstdint>
#include <vector>

#include "formats/map/compiled_map.h"

// Where along the route no look of a map is good enough, or none is much better than it must be.

namespace sightline {

struct WeakStretchOptions {
  double limit_m = 0.0;  // one of the map's; 0: the tightest
  // A site is weak where its best look's predicted error leaves less than this share of the limit.
  double least_margin = 0.5;
  double join_m = 5.0;      // weak sites of a run no farther apart are one stretch
  double longest_m = 50.0;  // a longer one is split into pieces of at most this length
};

// The best that the map predicts for a site: its look or range of least mean error, the cheaper on
// a tie.
struct BestLook {
  Look look;
  double error_m = 0.0;
  double probability = 0.0;  // of an error within the limit
  double margin = 0.0;       // 1 - error over limit: 0 at the limit, below 0 beyond it
  bool is_unmet = false;     // no range and no look is good enough (kUnmet of all choices)
};

struct WeakStretch {
  std::uint32_t run = 0;
  std::size_t first_site = 0;
  std::size_t last_site = 0;
  double from_m = 0.0;  // arc length of these two along the run
  double to_m = 0.0;
  std::size_t unmet_count = 0;  // sites
  std::size_t worst_site = 0;   // an unmet one where there is any, of the least margin
  BestLook worst;
};

// The limit of a map: its number among the promises. Error: bad-argument (no limit of the map).
Result<std::size_t> limit_of(const CompiledMap& map, double limit_m);

// One for each site.
std::vector<BestLook> best_looks(const CompiledMap& map, std::size_t limit);

// The worst first: those with an unmet site, then by margin. `best` is of all sites of the map.
std::vector<WeakStretch> weak_stretches(const Sites& sites, const std::vector<BestLook>& best,
                                        const WeakStretchOptions& options);

}  // namespace sightline
