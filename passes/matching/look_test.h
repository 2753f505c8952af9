#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "formats/geometry.h"
#include "passes/matching/matcher.h"

namespace sightline {

// What a match tells of itself to a vehicle that does not know the truth ("Driving by a plan" in
// schemas/definitions.md).
inline constexpr std::size_t kLookSigns = 8;
using LookSigns = std::array<double, kLookSigns>;
std::span<const std::string_view> look_sign_names();

// Of a match of so many points that was started from the foretold pose. Finite for any match.
// Allocates nothing.
LookSigns look_signs(const MatchResult& match, std::size_t point_count, const Pose& T_map_foretold);

// A linear test of a look. What it gives is the logarithm of odds, learnt, that the match is off by
// more than a limit.
struct LookTest {
  LookSigns weights{};
  double constant = 0.0;
};
double doubt_of(const LookTest& test, const LookSigns& signs);

}  // namespace sightline
