#include "formats/range_rule.h"

#include <algorithm>
#include <limits>

namespace sightline {
namespace {

template <class IsEnough>
std::optional<std::size_t> first_range(const PredictedError& predicted, const IsEnough& is_enough) {
  for (std::size_t range = 0; range < predicted.ranges_m.size(); ++range) {
    if (is_enough(range)) return range;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::size_t> range_by_mean(const PredictedError& predicted, std::size_t site,
                                         double limit_m) {
  return first_range(predicted,
                     [&](std::size_t range) { return predicted.mean(site, range) <= limit_m; });
}

std::optional<std::size_t> range_by_probability(const PredictedError& predicted, std::size_t site,
                                                std::size_t limit, double p) {
  return first_range(predicted, [&](std::size_t range) {
    return predicted.probability(site, range, limit) >= p;
  });
}

std::optional<std::size_t> range_by_worth(const PredictedError& predicted, std::size_t site,
                                          std::size_t limit, double p) {
  constexpr double kMoreLikelyThanNot = 0.5;
  const double longest_m = predicted.ranges_m.back();
  double within = 0.0;
  double least = std::numeric_limits<double>::infinity();
  std::size_t best = 0;
  for (std::size_t range = 0; range < predicted.ranges_m.size(); ++range) {
    within = std::max(within, predicted.probability(site, range, limit));
    const double cost = p * (1.0 - within) + (1.0 - p) * predicted.ranges_m[range] / longest_m;
    if (cost >= least) continue;
    least = cost;
    best = range;
  }
  if (within < kMoreLikelyThanNot) return std::nullopt;
  return best;
}

std::optional<std::size_t> own_range(const RangeTable& table, const PredictedError& predicted,
                                     std::size_t site, std::size_t limit) {
  const LimitPromise& promise = table.promises[limit];
  const double p = predicted.has_history[site] == 1 ? promise.history_threshold
                                                    : promise.probability_threshold;
  switch (table.selection) {
    case Selection::kMean:
      return range_by_mean(predicted, site, promise.limit_m);
    case Selection::kProbability:
      return range_by_probability(predicted, site, limit, p);
    case Selection::kWorth:
      return range_by_worth(predicted, site, limit, p);
  }
  return std::nullopt;
}

}  // namespace sightline
