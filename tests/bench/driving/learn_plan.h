#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tests/bench/driving/driven_town.h"

namespace sightline {

// A first look of a vehicle that tracks, and whether it was off by more than kDoubted_m.
struct LookExample {
  LookSigns signs{};
  bool is_off = false;
  bool is_beyond_limit = false;  // 10 cm
};
inline constexpr double kDoubted_m = 0.05;  // half of the limit
inline constexpr double kLimit_m = 0.10;
using DrivenTowns = std::vector<std::unique_ptr<DrivenTown>>;

// Of each town, from both drives, with a second look at every scan.
std::vector<std::vector<LookExample>> examples_of(const DrivenTowns& towns, const LookPlan& plan,
                                                  int threads);

// Logistic regression by Newton's method with a small penalty on standardized weights.
LookTest learn_look_test(std::span<const LookExample> examples);

// How likely the test doubts a look that is beyond the limit more than one that is not; equal
// doubts count half. No number where all looks are of one kind.
double area_under_curve(std::span<const LookExample> examples, const LookTest& test);

// Test and threshold from all towns but one (`left_out` = their number: from all). The threshold
// lets the second look follow in the least share of their first looks, of 1, 2, 3, 5, 8, 12 and
// 20 %, with which their drives in closed loop lose no scan and hold 10 cm at 99.8 %; else in that
// which holds it most often.
LookPlan learn_plan(const DrivenTowns& towns, const std::vector<std::vector<LookExample>>& examples,
                    const LookPlan& looks, std::size_t left_out, int threads);

}  // namespace sightline
