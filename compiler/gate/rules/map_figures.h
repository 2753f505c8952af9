#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "compiler/gate/rules/rules.h"
#include "formats/map/compiled_map.h"

// Figures of a map that rules of the gate are about.

namespace sightline {

RouteStretch stretch_between(const Sites& sites, std::size_t first, std::size_t last);

// "sites 120 to 163 (run 0, 120 to 163 m, around (12.0, -64.5, 1.8) m in the world)"
std::string in_words(const RouteStretch& stretch);

struct StretchSearch {
  double length_m = 0.0;  // of route that is judged at a time
  Bound bound = Bound::kAtMost;
};

struct BadStretch {
  std::size_t first = 0;  // sites
  std::size_t last = 0;
  double worst = 0.0;  // mean over the worst `length_m` in it
  std::size_t worst_first = 0;
  std::size_t worst_last = 0;
};

// Means of `value` over every piece of route of length_m (a run that is shorter: all of it). Those
// that are not within `allowed` are joined where they touch, and cut at both ends back to the first
// and last site that is itself not within it. NaN: the site has no value and ends a piece. The
// stretches ascend by site.
std::vector<BadStretch> bad_stretches(const Sites& sites, const std::vector<double>& value,
                                      const StretchSearch& search, double allowed);

// The worst such piece, the first on a tie; `last` < `first` where no site has a value.
BadStretch worst_stretch(const Sites& sites, const std::vector<double>& value,
                         const StretchSearch& search);

// Those bad stretches, or the worst where none is bad (`allowed`: none: nothing is bad).
std::vector<BadStretch> bad_or_worst(const Sites& sites, const std::vector<double>& value,
                                     const StretchSearch& search, std::optional<double> allowed);

// A piece of route whose sites are all `is_bad`, with the length between first and last site.
struct LongStretch {
  std::size_t first = 0;
  std::size_t last = 0;
  double length_m = 0.0;
};
std::vector<LongStretch> long_stretches(const Sites& sites, const std::vector<bool>& is_bad);

// A number of the whole map at one of its limits.
struct LimitFigure {
  std::string_view what;  // "mean range": messages go on with " within 0.1 m is 12.0 m"
  std::string_view unit;
  double (*of)(const CompiledMap& map, std::size_t limit);  // NaN: the map has none
};

double share_of_sites(const CompiledMap& map, std::uint32_t count);

// The least chosen range that at least 95 % of the sites do not exceed.
double p95_range_m(const CompiledMap& map, std::size_t limit);

bool has_virtual_points(const CompiledMap& map);
// Sum over sites of the factor virtual_points at the chosen range over that at the longest; NaN
// where the map holds no such factor.
double expected_work(const CompiledMap& map, std::size_t limit);

inline constexpr LimitFigure kExpectedCoverage = {
    "expected coverage", "share",
    [](const CompiledMap& map, std::size_t limit) { return map.quality[limit].expected_coverage; }};
inline constexpr LimitFigure kMeanRange = {
    "mean range", "m",
    [](const CompiledMap& map, std::size_t limit) { return map.quality[limit].mean_range_m; }};
inline constexpr LimitFigure kUnmetShare = {"the share of sites where no range is good enough",
                                            "share", [](const CompiledMap& map, std::size_t limit) {
                                              return share_of_sites(map,
                                                                    map.quality[limit].unmet_count);
                                            }};
inline constexpr LimitFigure kExtrapolatedShare = {
    "the share of sites unlike those that the model was trained on", "share",
    [](const CompiledMap& map, std::size_t limit) {
      return share_of_sites(map, map.quality[limit].extrapolated_count);
    }};
inline constexpr LimitFigure kExpectedWork = {"the expected work of a match", "of the longest",
                                              &expected_work};

// P(error <= limit) of a site at its chosen range.
double chosen_probability(const CompiledMap& map, std::size_t site, std::size_t limit);

std::vector<bool> unmet_sites(const CompiledMap& map, std::size_t limit);

}  // namespace sightline
