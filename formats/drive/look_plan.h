#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/drive/look.h"
#include "formats/record/fields.h"

namespace sightline {

// What a match shows to a vehicle that does not know the truth ("Driving by a plan" in
// schemas/definitions.md); passes/matching/look_test.h reads it off a match.
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
