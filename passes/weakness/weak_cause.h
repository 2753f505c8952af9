#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "passes/weakness/site_view.h"

// Why a place is weak: what the sensor sees there that could hold it, and what does not.

namespace sightline {

enum class WeakCause : std::uint8_t {
  kEmpty,     // few upright surfaces in sight
  kOneSided,  // all of them face one way: a corridor, a bare wall
  kRepeated,  // what is seen looks the same half a metre and more further along the loose direction
  kDistant,   // what holds the loose direction is far
  kUnclear    // what is seen should hold the place: the reason is not in the geometry
};
std::string_view name_of(WeakCause cause);  // "empty", "one-sided", "repeated", ...

// Upright surfaces that a scan meets: NDs of class 2 whose normal is within 30 degrees of level.
// One holds a direction where its normal is within 30 degrees of it.
struct UprightSights {
  std::size_t count = 0;
  std::size_t holding_count = 0;            // of them, those that hold the loose direction
  std::optional<double> nearest_holding_m;  // of these, from the sensor to the mean; nothing: none
  double one_sidedness = 0.0;  // 1 - least over largest eigenvalue of the summed n n^T, horizontal
                               // part, of them all; 1: all face one way; 0 where there are none
};
UprightSights upright_sights(const SiteView& view, const NearNds& nds, double loose_heading_deg);

// `rival_score` as of schemas/definitions.md, nothing where it is not known; `range_m` is how far
// was looked.
WeakCause cause_of(const UprightSights& sights, std::optional<double> rival_score, double range_m);

}  // namespace sightline
