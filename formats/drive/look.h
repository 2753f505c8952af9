#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/record/fields.h"

namespace sightline {

// How a localization begins: searching from up to a metre off, or settling on the last level alone,
// for a vehicle that tracks.
enum class LookMode : std::uint8_t { kSearch, kSettle };
template <>
inline constexpr auto kNamesOf<LookMode> = enum_names("search", "settle");

// How a vehicle's scan becomes the points that are matched (schemas/definitions.md, "Looks").
// As text, in this order, what is left out in brackets:
//
//   50 m[, 2000 returns][, evenly spaced beyond 30 m][, 80 points[ by normals]][, settle]
struct Look {
  double range_m = 50.0;  // 3D slant range from the sensor
  // So many returns of a scan are looked at, spread evenly; 0: every one, and each voxel gives the
  // centroid of its returns, else its first return.
  std::uint32_t return_count = 0;
  // A return nearer than this is kept with chance (r / even_beyond_m)^2, which undoes that near
  // surfaces get more returns; 0: all are kept.
  double even_beyond_m = 0.0;
  std::uint32_t point_count = 0;  // matched at most; 0: all that are left
  bool is_by_normals = false;     // they are taken in turn from the directions of the map's normals
  LookMode mode = LookMode::kSearch;
  friend bool operator==(const Look&, const Look&) = default;
};
SIGHTLINE_FIELDS(Look, range_m, return_count, even_beyond_m, point_count, is_by_normals, mode)

// The paper's: every return within the range.
inline Look every_return(double range_m) { return {.range_m = range_m}; }
inline bool takes_every_return(const Look& look) { return look.return_count == 0; }
std::vector<Look> every_return_at(const std::vector<double>& ranges_m);  // one for each
std::vector<double> ranges_of(const std::vector<Look>& looks);           // of each, m

std::string to_text(const Look& look);

// What a localization by a look that takes a sample costs, in matched points: fitted to
// tests/bench/look_bench ("Factor from the mapping drive" in schemas/definitions.md, match_cost).
double expected_cost(const Look& look);

// Reads what to_text() writes, and "even beyond 30 m" of earlier versions. Error: bad-argument,
// whose message names the fault and shows an example.
Result<Look> parse_look(std::string_view text);

// Several looks, with "; " between one and the next. Read back, a comma will do, since each begins
// with its range; a list in brackets is read too. Error: bad-argument, also for a look that stands
// twice and for none.
std::string to_text(const std::vector<Look>& looks);
Result<std::vector<Look>> parse_looks(std::string_view text);

// Range and even_beyond_m above 0 and below 1000 m; a sample has returns; normals and
// even_beyond_m need a sample, normals a number of points. Error: bad-argument.
Result<void> validate(const Look& look);

// What the tables of a map are ordered by: one look or more, each valid, none twice; those that
// take every return ascend by range. Error: invalid-artifact, naming the look.
Result<void> validate(const std::vector<Look>& looks);

// What a match shows to a vehicle that does not know the truth ("Driving by a plan" in
// schemas/definitions.md); passes/matching/look_plan.h reads it off a match.
inline constexpr std::size_t kLookSigns = 8;
using LookSigns = std::array<double, kLookSigns>;
std::span<const std::string_view> look_sign_names();

// A linear test of a look. What it gives is the logarithm of odds, learnt, that the match is off by
// more than a limit.
struct LookTest {
  LookSigns weights{};
  double constant = 0.0;
  friend bool operator==(const LookTest&, const LookTest&) = default;
};
SIGHTLINE_FIELDS(LookTest, weights, constant)
double doubt_of(const LookTest& test, const LookSigns& signs);

// How a vehicle localizes that tracks: a cheap look from where it predicted itself; a test of what
// that match shows; and where the test doubts it, a dearer look whose result stands
// instead ("Driving by a plan" in schemas/definitions.md).
struct LookPlan {
  double limit_m = 0.10;  // that it was learnt to hold
  Look first;
  LookTest test;             // of the first look
  double doubt_above = 0.0;  // log odds: the second look follows where the test gives more
  Look second;
  friend bool operator==(const LookPlan&, const LookPlan&) = default;
};
SIGHTLINE_FIELDS(LookPlan, limit_m, first, test, doubt_above, second)

// Limit above 0 and finite; both looks valid; weights and constant finite; doubt_above a number, or
// infinite: then the second look never follows (+) or always (-). Error: bad-argument.
Result<void> validate(const LookPlan& plan);

// The plan at a place whose look is that: where it looks at no more returns than the plan's first
// and matches fewer points, it comes first, settling.
LookPlan plan_at(const LookPlan& plan, const Look& look);

// The limit and the two looks, for people.
std::string to_text(const LookPlan& plan);

}  // namespace sightline
