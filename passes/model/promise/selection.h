#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/model/error_model.h"

// The rules by which a range is chosen (schemas/definitions.md, "Error model and choice of range"),
// each a pure function, so that choosing, calibrating and judging apply one and the same rule.

namespace sightline {

// Where a site lies along its route.
struct RoutePoint {
  std::uint32_t run = 0;
  double s_m = 0.0;
};
std::vector<RoutePoint> route_of(const Sites& sites);
std::vector<RoutePoint> route_of(const std::vector<TrainedSite>& sites);

// The choice for one limit.
struct Choice {
  std::vector<std::uint8_t> range_index;  // [site]
  std::vector<std::uint8_t> flags;        // [site]: kUnmet, kExtrapolated, kStatic
  std::vector<Reason> reasons;            // [site]

  [[nodiscard]] bool is_answered(std::size_t site) const { return (flags[site] & kUnmet) == 0; }
};
Choice choose_everywhere(std::size_t range, std::size_t site_count);  // no flags, Reason::kNone

// Each site by a rule of formats/annotation/range_rule.h. Where it finds no range: kUnmet, and the
// longest by mean, the most probable one (the shortest of these) by probability.
Choice choose_by_mean(const PredictedError& predicted, double limit_m);

// The least probability of an answer of the probability rule: no site is answered below it, however
// many misses are allowed. (One town missed 20 % at thresholds of 0.28 to 0.49, where 10 % were
// allowed.)
inline constexpr double kLeastProbability = 0.7;

// The thresholds that are tried for p*: kLeastProbability, 0.705, ..., 1. 200 trees with five
// labels a leaf resolve no finer differences that would last from one seed to the next.
std::vector<double> tried_thresholds();

// p*: sites with measured history are judged by a threshold of their own, since the model knows
// them better.
struct Thresholds {
  double map_only = 0.0;
  double history = 0.0;

  [[nodiscard]] double at(const PredictedError& predicted, std::size_t site) const {
    return predicted.has_history[site] == 1 ? history : map_only;
  }
};

Choice choose_by_probability(const PredictedError& predicted, std::size_t limit,
                             const Thresholds& thresholds);

// Each site takes the look that is given for it; kUnmet where that has a lower probability than the
// site's threshold.
Choice choose_given(const PredictedError& predicted, std::size_t limit,
                    const std::vector<double>& threshold_of_site,
                    const std::vector<std::uint8_t>& look_of_site);

// Flags the sites whose own answer is extrapolated.
void mark_extrapolated(const PredictedError& predicted, Choice& choice);

// A site takes the longest range among itself and the sites of its run within dilation_m.
void dilate(const std::vector<RoutePoint>& route, double dilation_m, Choice& choice);

// What meets a tighter limit meets a looser one: a site that looks no further for the tighter limit
// need not for the looser (Reason::kTighterLimit). With the range the flag kStatic is
// copied. Where the tighter limit is met, so is the looser: kUnmet is cleared.
void cap_by_tighter(const Choice& tighter, Choice& choice);

}  // namespace sightline
