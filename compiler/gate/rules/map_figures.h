#pragma once

#include <string_view>
#include <vector>

#include "formats/map/compiled_map.h"

// Figures of a map that rules of the gate are about.

namespace sightline {

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
    "the share of sites unlike what the model was trained on", "share",
    [](const CompiledMap& map, std::size_t limit) {
      return share_of_sites(map, map.quality[limit].extrapolated_count);
    }};
inline constexpr LimitFigure kExpectedWork = {"the expected work of a match", "of the longest",
                                              &expected_work};

// P(error <= limit) of a site at its chosen range.
double chosen_probability(const CompiledMap& map, std::size_t site, std::size_t limit);

// By site.
std::vector<bool> unmet_sites(const CompiledMap& map, std::size_t limit);

}  // namespace sightline
