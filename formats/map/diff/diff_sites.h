#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "formats/map/diff/diff_tiles.h"
#include "formats/map/diff/map_diff.h"
#include "formats/map/diff/map_side.h"

// What two maps tell at the same places.

namespace sightline {

// A limit that both maps have, as the index of it in each.
using CommonLimits = std::vector<std::pair<std::size_t, std::size_t>>;
CommonLimits common_limits(const CompiledMap& before, const CompiledMap& after);

// A site of the new map beside the old map's answer there; answers are of the common limits.
struct ComparedSite {
  const SiteRow* row = nullptr;
  bool is_known_before = false;
  std::vector<AnswerDiff> answers;  // where it is known
  double distance_m = 0.0;          // to the old site
  double longest_points_before = 0.0;
  double longest_points_after = 0.0;
};
// A site that the old map has as well.
ComparedSite same_site(const SiteRow& row, const CommonLimits& limits);

// By site: those of every new tile where NDs or answers may differ; of the old map those of such
// tiles where the new map has no answer.
struct ComparedSites {
  std::map<std::uint32_t, ComparedSite> after;
  std::map<std::uint32_t, const SiteRow*> only_before;
};
Result<ComparedSites> compare_sites(MapSide& before, MapSide& after,
                                    std::span<const TilePair> tiles);

// Fills sites, limits and their counts of `diff`.
void count_sites(const CompiledMap& before, const CompiledMap& after, const ComparedSites& compared,
                 MapDiff& diff);

}  // namespace sightline
