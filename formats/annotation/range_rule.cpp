#include "formats/annotation/range_rule.h"

namespace sightline {
namespace {

template <class IsEnough>
std::optional<std::size_t> first_range(const PredictedError& predicted, const IsEnough& is_enough) {
  for (std::size_t range = 0; range < predicted.looks.size(); ++range) {
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
  return first_range(
      predicted, [&](std::size_t range) { return predicted.probability(site, range, limit) >= p; });
}

std::optional<std::size_t> own_range(const RangeTable& table, const PredictedError& predicted,
                                     std::size_t site, std::size_t limit) {
  const LimitPromise& promise = table.promises[limit];
  if (table.selection == Selection::kMean) return range_by_mean(predicted, site, promise.limit_m);
  const double p =
      predicted.has_history[site] == 1 ? promise.history_threshold : promise.probability_threshold;
  return range_by_probability(predicted, site, limit, p);
}

Answer answer_of(const RangeTable& table, const PredictedError& predicted, std::size_t site,
                 std::size_t limit) {
  const std::size_t look = table.range(site, limit);
  return {table.looks[look], predicted.probability(site, look, limit), predicted.mean(site, look),
          table.flags_of(site, limit), table.reason(site, limit)};
}

}  // namespace sightline
