#include "passes/choose_ranges.h"

#include <algorithm>

#include "passes/learn/calibration.h"
#include "passes/learn/selection.h"

namespace sightline {
namespace {

// A range is stored as one byte, in the table and in the map.
constexpr std::size_t kMostRanges = 255;

Result<void> check_inputs(const Sites& sites, const PredictedError& predicted,
                          const ErrorModel& model) {
  if (predicted.site_count != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found predictions of " + std::to_string(predicted.site_count) +
                     " sites, expected " + std::to_string(sites.sites.size()),
                 "", ""};
  }
  if (predicted.ranges_m != model.out_of_fold.ranges_m ||
      predicted.limits_m != model.out_of_fold.limits_m) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions and model are of different ranges or limits", "", ""};
  }
  if (predicted.ranges_m.size() > kMostRanges) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found " + std::to_string(predicted.ranges_m.size()) +
                     " ranges, expected at most " + std::to_string(kMostRanges),
                 "", ""};
  }
  return {};
}

struct Chosen {
  std::vector<LimitPromise> promises;
  std::vector<Choice> choices;  // [limit], of the map's sites
};

Chosen choose_all_by_mean(const ChooseRangesOptions& options, const PredictedError& predicted,
                          const ErrorModel& model) {
  Chosen chosen;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    chosen.promises.push_back(assess_mean_rule(model, limit));
    chosen.choices.push_back(choose_by_mean(predicted, predicted.limits_m[limit]));
    mark_extrapolated(predicted, options.extrapolated_takes_longest, chosen.choices.back());
  }
  return chosen;
}

Chosen choose_all_by_probability(const ChooseRangesOptions& options, const Sites& sites,
                                 const PredictedError& predicted, const ErrorModel& model) {
  const CalibrationOptions calibration_options{options.risk_control, options.alpha, options.delta,
                                               options.probability_threshold, options.dilation_m};
  const std::vector<RoutePoint> route = route_of(sites);
  Chosen chosen;
  std::vector<Calibration> calibrations;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    const Choice* tighter = limit == 0 ? nullptr : &calibrations.back().choice;
    Calibration calibration = calibrate_probability(model, limit, calibration_options, tighter);
    Choice choice =
        choose_by_probability(predicted, limit, calibration.promise.probability_threshold);
    mark_extrapolated(predicted, options.extrapolated_takes_longest, choice);
    dilate(route, options.dilation_m, choice);
    if (limit > 0) cap_by_tighter(chosen.choices.back(), choice);
    chosen.promises.push_back(calibration.promise);
    chosen.choices.push_back(std::move(choice));
    calibrations.push_back(std::move(calibration));
  }
  return chosen;
}

RangeTable to_table(const PredictedError& predicted, Chosen chosen) {
  RangeTable table;
  table.ranges_m = predicted.ranges_m;
  table.site_count = predicted.site_count;
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    for (const Choice& choice : chosen.choices) {
      table.range_index.push_back(choice.range_index[site]);
      table.flags.push_back(choice.flags[site]);
    }
  }
  table.promises = std::move(chosen.promises);
  return table;
}

void warn_of_flags(const PassContext& ctx, const RangeTable& table) {
  for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
    std::size_t unmet_count = 0;
    for (std::size_t site = 0; site < table.site_count; ++site) {
      const std::uint8_t flags = table.flags[site * table.promises.size() + limit];
      unmet_count += (flags & kUnmet) != 0 ? 1 : 0;
    }
    if (unmet_count == 0) continue;
    ctx.warn("no range is good enough for " + format_double(table.promises[limit].limit_m) +
             " m at " + std::to_string(unmet_count) + " of " + std::to_string(table.site_count) +
             " sites: they look as far as there is, and are flagged");
  }
}

}  // namespace

std::vector<OptionField> option_fields(ChooseRangesOptions& options) {
  return {
      choice("selection", options.selection,
             "rule: by probability with a promise, or by mean as the paper does",
             {"probability", "mean"}),
      choice("risk_control", options.risk_control, "what sets the probability that is asked for",
             {"conformal", "learn-then-test", "empirical", "fixed"}),
      number("alpha", options.alpha, "share of misses that is allowed", 0.0001, 0.5),
      number("delta", options.delta, "learn-then-test: how often the promise itself may fail",
             0.0001, 0.5),
      number("probability_threshold", options.probability_threshold,
             "the probability asked for where risk_control is fixed", 0.0, 1.0),
      number("dilation_m", options.dilation_m,
             "a site looks as far as any neighbour within this, m", 0.0, 100.0),
      flag("extrapolated_takes_longest", options.extrapolated_takes_longest,
           "look as far as there is where factors lie beyond what the model saw")};
}

Result<RangeTable> choose_ranges(PassContext& ctx, const ChooseRangesOptions& options,
                                 const Sites& sites, const PredictedError& predicted,
                                 const ErrorModel& model) {
  const Result<void> checked = check_inputs(sites, predicted, model);
  if (!checked) return checked.error();
  const bool is_mean = options.selection == "mean";
  RangeTable table =
      to_table(predicted, is_mean ? choose_all_by_mean(options, predicted, model)
                                  : choose_all_by_probability(options, sites, predicted, model));
  table.selection = is_mean ? Selection::kMean : Selection::kProbability;
  table.dilation_m = is_mean ? 0.0 : options.dilation_m;
  warn_of_flags(ctx, table);
  return table;
}

}  // namespace sightline
