#pragma once

#include <span>
#include <vector>

#include "formats/geometry.h"
#include "passes/matching/kernel_score.h"
#include "passes/matching/matcher.h"

namespace sightline {

// The searching localizer (schemas/definitions.md, "Localizers").
struct OptimumSearch {
  std::span<const MatchLevel> levels;  // two at least; the first shows the way
  double search_m = 0.0;               // another optimum is looked for no farther from the start
  double loose_below = 0.5;            // LocalizerOptions'
  MatchOptions options;
};

// What starts of one scan found, by one search. Where the first level of a start ends nearly where
// an earlier one's did, both go on alike: in a street, most starts do. Such a start takes over what
// the earlier one found, and what that took. Empty for another scan or another search.
class SharedClimbs {
 public:
  // Two poses are one where no point of the scan within 10 m moves by more than about this.
  static constexpr double kSame_m = 0.01;

  struct Climb {
    Pose T_map_lead = Pose::Identity();  // where the first level ended
    MatchResult found;                   // `iterations` and `work` of all after the first level
  };
  // The first that ended near; null: none.
  [[nodiscard]] const Climb* find(const Pose& T_map_lead) const;
  void add(const Climb& climb) { climbs_.push_back(climb); }
  void clear() { climbs_.clear(); }

 private:
  std::vector<Climb> climbs_;
};

// Allocates nothing where `shared` is null.
MatchResult search_optimum(const OptimumSearch& search, const Pose& T_map_start, ScanForMatch& scan,
                           SharedClimbs* shared);

}  // namespace sightline
