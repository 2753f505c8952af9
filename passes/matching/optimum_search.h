#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
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

// A part of a search, and what it took.
struct SearchPart {
  std::optional<MatchResult> found;
  int iterations = 0;
  std::uint64_t work = 0;
  double cpu_ms = 0.0;  // where climbs are shared; for reports alone
};

// How a search goes on from where its first level ended. Nothing here depends on the start but
// which of `from_probes` it takes.
struct Climb {
  static constexpr int kProbes = 5;  // to each side

  Pose T_map_lead = Pose::Identity();
  SearchPart straight;  // scores along the loose direction, and the other levels from here
  // Horizontal, of length 1; nothing where no direction is loose, and then there are no scores.
  std::optional<Eigen::Vector2d> loose_direction;
  std::array<double, 2 * kProbes + 1> scores{};
  // By number of the probe, those that a start took so far: all levels from there.
  std::vector<std::pair<int, SearchPart>> from_probes;
};

// What starts of one scan found, by one search. Where the first level of a start ends nearly where
// an earlier one's did, both go on alike: in a street, most starts do. Such a start takes over what
// the earlier one found from there, and what that took. Which other optimum is tried, its own
// place decides. Empty for another scan or another search.
class SharedClimbs {
 public:
  // Two poses are one where no point of the scan within 10 m moves by more than about this.
  static constexpr double kSame_m = 0.01;
  [[nodiscard]] static bool are_one(const Pose& a, const Pose& b);

  void clear() {
    climbs_.clear();
    taken_over_ms_ = 0.0;
  }
  // CPU time of what the last search took over, which a start of its own would have spent.
  [[nodiscard]] double taken_over_ms() const { return taken_over_ms_; }

  // From where the first level of a start ended.
  MatchResult go_on(const MatchResult& lead, const OptimumSearch& search, const Pose& T_map_start,
                    ScanForMatch& scan);

 private:
  Climb& climb_of(const MatchResult& lead, const OptimumSearch& search, ScanForMatch& scan);
  const SearchPart& part_of(int probe, Climb& climb, const OptimumSearch& search,
                            ScanForMatch& scan);

  std::vector<Climb> climbs_;
  double taken_over_ms_ = 0.0;
};

// Allocates nothing where `shared` is null.
MatchResult search_optimum(const OptimumSearch& search, const Pose& T_map_start, ScanForMatch& scan,
                           SharedClimbs* shared);

}  // namespace sightline
