#include "passes/model/promise/selection.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "formats/annotation/range_rule.h"

namespace sightline {
namespace {

// Positions come from sums of steps of a metre: exactly 3 m apart may read 3.0000000001.
constexpr double kPositionTolerance_m = 1e-6;

using RangeOfSite = std::function<std::optional<std::size_t>(std::size_t site)>;

Choice choose_each(const PredictedError& predicted, const RangeOfSite& range_of,
                   const std::function<std::size_t(std::size_t site)>& otherwise) {
  Choice choice;
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    const std::optional<std::size_t> range = range_of(site);
    choice.range_index.push_back(static_cast<std::uint8_t>(range ? *range : otherwise(site)));
    choice.flags.push_back(range ? std::uint8_t{0} : kUnmet);
    choice.reasons.push_back(range ? Reason::kModel : Reason::kMostProbable);
  }
  return choice;
}

// The shortest of equals.
std::size_t most_probable(const PredictedError& predicted, std::size_t site, std::size_t limit) {
  std::size_t best = 0;
  for (std::size_t range = 1; range < predicted.looks.size(); ++range) {
    const bool is_better =
        predicted.probability(site, range, limit) > predicted.probability(site, best, limit);
    if (is_better) best = range;
  }
  return best;
}

}  // namespace

std::vector<RoutePoint> route_of(const Sites& sites) {
  std::vector<RoutePoint> route;
  for (const Site& site : sites.sites) route.push_back({site.run, site.s_m});
  return route;
}

std::vector<RoutePoint> route_of(const std::vector<TrainedSite>& sites) {
  std::vector<RoutePoint> route;
  for (const TrainedSite& site : sites) route.push_back({site.run, site.s_m});
  return route;
}

std::vector<double> tried_thresholds() {
  constexpr int kSteps = 200;
  std::vector<double> thresholds;
  for (int i = 0; i <= kSteps; ++i) {
    const double threshold = static_cast<double>(i) / kSteps;
    if (threshold >= kLeastProbability) thresholds.push_back(threshold);
  }
  return thresholds;
}

Choice choose_everywhere(std::size_t range, std::size_t site_count) {
  return {std::vector<std::uint8_t>(site_count, static_cast<std::uint8_t>(range)),
          std::vector<std::uint8_t>(site_count, 0), std::vector<Reason>(site_count, Reason::kNone)};
}

Choice choose_by_mean(const PredictedError& predicted, double limit_m) {
  return choose_each(
      predicted, [&](std::size_t site) { return range_by_mean(predicted, site, limit_m); },
      [&](std::size_t) { return predicted.looks.size() - 1; });
}

Choice choose_by_probability(const PredictedError& predicted, std::size_t limit,
                             const Thresholds& thresholds) {
  return choose_each(
      predicted,
      [&](std::size_t site) {
        return range_by_probability(predicted, site, limit, thresholds.at(predicted, site));
      },
      [&](std::size_t site) { return most_probable(predicted, site, limit); });
}

Choice choose_given(const PredictedError& predicted, std::size_t limit,
                    const std::vector<double>& threshold_of_site,
                    const std::vector<std::uint8_t>& look_of_site) {
  Choice choice = choose_everywhere(0, predicted.site_count);
  choice.range_index = look_of_site;
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    const bool is_met =
        predicted.probability(site, look_of_site[site], limit) >= threshold_of_site[site];
    choice.reasons[site] = is_met ? Reason::kModel : Reason::kMostProbable;
    if (!is_met) choice.flags[site] = kUnmet;
  }
  return choice;
}

void mark_extrapolated(const PredictedError& predicted, Choice& choice) {
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    if (predicted.is_extrapolated(site, choice.range_index[site])) {
      choice.flags[site] |= kExtrapolated;
    }
  }
}

void dilate(const std::vector<RoutePoint>& route, double dilation_m, Choice& choice) {
  const std::vector<std::uint8_t> own = choice.range_index;
  const double reach_m = dilation_m + kPositionTolerance_m;
  std::size_t first = 0;
  for (std::size_t site = 0; site < route.size(); ++site) {
    const auto is_neighbour = [&](std::size_t other) {
      return route[other].run == route[site].run &&
             std::abs(route[other].s_m - route[site].s_m) <= reach_m;
    };
    while (!is_neighbour(first)) ++first;
    for (std::size_t other = first; other < route.size() && is_neighbour(other); ++other) {
      choice.range_index[site] = std::max(choice.range_index[site], own[other]);
    }
    if (choice.range_index[site] != own[site]) choice.reasons[site] = Reason::kDilation;
  }
}

void cap_by_tighter(const Choice& tighter, Choice& choice) {
  for (std::size_t site = 0; site < choice.range_index.size(); ++site) {
    if (tighter.range_index[site] < choice.range_index[site]) {
      choice.range_index[site] = tighter.range_index[site];
      choice.reasons[site] = Reason::kTighterLimit;
      choice.flags[site] &= static_cast<std::uint8_t>(~kStatic);
      choice.flags[site] |= static_cast<std::uint8_t>(tighter.flags[site] & kStatic);
    }
    if ((tighter.flags[site] & kUnmet) == 0) {
      choice.flags[site] &= static_cast<std::uint8_t>(~kUnmet);
    }
  }
}

}  // namespace sightline
