#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/map/compiled_map.h"

// What differs between two compiled maps, in the words of who drives by them: first by digest, so
// that tiles that stayed are not even read, then by meaning. Before is the old map, after the new.

namespace sightline {

struct MapDiffOptions {
  // An ND moved where its mean is farther than this from the old one, and outside the old one's
  // ellipsoid of one sigma: along a wall the mean wanders with the points that happen to hit it.
  double tolerance_m = 0.10;
  // A place changed where at least this share of the NDs nearest to sites within window_m of it
  // did. What one drive sees and the next does not is less.
  double changed_share = 0.05;
  double window_m = 5.0;
  double join_m = 25.0;      // two changes along a route no farther apart belong to one stretch
  double longest_m = 100.0;  // of a stretch: a longer one is split
};

// A property of the map as a whole: "frame.origin_world_m", "definitions.sites", "model.digest".
// Empty where a map has none.
struct FactDiff {
  std::string name;
  std::string before;
  std::string after;
};

// Layers or sections of one name. `required` ones are what a vehicle acts on.
struct BlockDiff {
  std::string name;
  bool is_required = false;
  std::uint64_t added = 0;
  std::uint64_t removed = 0;
  std::uint64_t changed = 0;
  std::uint64_t same = 0;
};

enum class NdChange : std::uint8_t { kAdded, kRemoved, kMoved };

struct NdDiff {
  NdChange change = NdChange::kAdded;
  Eigen::Vector3d mean_world_m = Eigen::Vector3d::Zero();  // after; before of one removed
  double moved_m = 0.0;
};

// A map's answer at one place for one limit.
struct SiteAnswer {
  double range_m = 0.0;
  double probability = 0.0;  // at that range
  std::uint8_t flags = 0;
  Reason reason = Reason::kNone;
  double virtual_points = 0.0;  // of a scan at that range, what matching time goes by; 0: not known

  [[nodiscard]] bool is_unmet() const { return (flags & kUnmet) != 0; }
};

// For a limit that both maps know.
struct AnswerDiff {
  SiteAnswer before;
  SiteAnswer after;

  [[nodiscard]] bool is_different() const {
    return before.range_m != after.range_m || before.flags != after.flags;
  }
  // Into a LimitDiff or a StretchLimit.
  template <class Counts>
  void add_to(Counts& counts) const {
    if (after.range_m > before.range_m) ++counts.rose;
    if (after.range_m < before.range_m) ++counts.fell;
    if (after.is_unmet() && !before.is_unmet()) ++counts.newly_unmet;
    if (before.is_unmet() && !after.is_unmet()) ++counts.no_longer_unmet;
  }
};

// kAdded: the old map says nothing there, no site of it lies within its reach. kRemoved: likewise
// of the new map; such a site is one of the old map.
enum class SiteChange : std::uint8_t { kAdded, kRemoved, kChanged };

// A site whose answer differs: another range, or other flags, for some limit.
struct SiteDiff {
  SiteChange change = SiteChange::kChanged;
  std::uint32_t site = 0;
  std::uint32_t run = 0;
  double s_m = 0.0;
  Eigen::Vector3d p_world_m = Eigen::Vector3d::Zero();
  double distance_m = 0.0;          // to the old site that answered here
  std::vector<AnswerDiff> answers;  // [limit of MapDiff::limits that is common]; kChanged only
};

// Of one limit in one of the lists, or in both.
struct LimitDiff {
  double limit_m = 0.0;
  std::optional<LimitQuality>
      before;  // over all sites of each map; none where it has no such limit
  std::optional<LimitQuality> after;
  // Sites of the new map beside what the old one says in the same place; where both have the limit.
  std::uint32_t rose = 0;
  std::uint32_t fell = 0;
  std::uint32_t newly_unmet = 0;
  std::uint32_t no_longer_unmet = 0;
  // Expected work over the sites in changed tiles that both maps know: virtual points at the chosen
  // ranges over those at the longest. None where a map holds no such factor.
  std::optional<double> work_before;
  std::optional<double> work_after;

  [[nodiscard]] bool is_common() const { return before.has_value() && after.has_value(); }
};

// A stretch of route where something changed, for people to read.
struct StretchLimit {  // of one common limit, over the stretch's sites
  std::uint32_t rose = 0;
  std::uint32_t fell = 0;
  std::uint32_t newly_unmet = 0;
  std::uint32_t no_longer_unmet = 0;
  double mean_range_before_m = 0.0;  // over sites that both maps know there
  double mean_range_after_m = 0.0;
};
struct Stretch {
  bool is_of_old_map = false;      // route that the new map no longer has
  bool has_changed_place = false;  // not its answers alone: see MapDiffOptions::changed_share
  std::uint32_t run = 0;
  double begin_s_m = 0.0;
  double end_s_m = 0.0;
  std::uint32_t first_site = 0;
  std::uint32_t last_site = 0;
  std::vector<Eigen::Vector3d> line_world_m;  // its sites, in order
  std::uint64_t nds_added = 0;
  std::uint64_t nds_removed = 0;
  std::uint64_t nds_moved = 0;
  std::uint32_t sites_added = 0;
  std::uint32_t sites_removed = 0;
  std::vector<StretchLimit> limits;  // as SiteDiff::answers

  // The old map has none of its sites: there are no ranges to compare.
  [[nodiscard]] bool is_new() const { return !is_of_old_map && sites_added == line_world_m.size(); }
};

// One of the two maps.
struct DiffedMap {
  std::string map_id;
  std::string version;
  std::uint64_t release = 0;
  std::string world;  // CompiledMap::world
  Digest root_digest{};
  std::uint64_t nd_count = 0;
  std::uint32_t site_count = 0;
  std::uint32_t tile_count = 0;
  std::uint64_t file_size = 0;
};

struct MapDiff {
  DiffedMap before;
  DiffedMap after;
  MapDiffOptions options;
  std::vector<FactDiff> facts;
  std::vector<BlockDiff> blocks;  // ascending name; also those without a difference
  std::uint64_t tiles_added = 0;
  std::uint64_t tiles_removed = 0;
  std::uint64_t tiles_changed = 0;  // by their digest
  bool has_comparable_nds = true;   // false where cells or tiles do not coincide: nds is empty then
  std::vector<NdDiff> nds;
  std::uint64_t nds_added = 0;
  std::uint64_t nds_removed = 0;
  std::uint64_t nds_moved = 0;
  std::vector<LimitDiff> limits;  // of both maps, ascending
  std::vector<SiteDiff> sites;    // by site; those of the old map last
  std::uint32_t sites_added = 0;
  std::uint32_t sites_removed = 0;
  std::vector<Stretch> stretches;   // by run and s; those of the old map last
  std::uint64_t nds_off_route = 0;  // changed, in tiles without a site
  std::uint64_t nds_scattered = 0;  // changed, along the route but in none of the stretches
  std::uint64_t bytes_read = 0;     // of both files: their ends and the blocks that were read

  // Nothing differs but, perhaps, how blocks are packed.
  [[nodiscard]] bool is_same() const {
    return before.root_digest == after.root_digest &&
           std::ranges::all_of(blocks, [](const BlockDiff& block) {
             return block.added == 0 && block.removed == 0 && block.changed == 0;
           });
  }
};

// The limits that both maps have, ascending: what SiteDiff::answers and Stretch::limits go by.
inline std::vector<double> common_limits_m(const MapDiff& diff) {
  std::vector<double> common_m;
  for (const LimitDiff& limit : diff.limits) {
    if (limit.is_common()) common_m.push_back(limit.limit_m);
  }
  return common_m;
}

}  // namespace sightline
