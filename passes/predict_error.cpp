#include "passes/predict_error.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "passes/learn/feature_rows.h"
#include "passes/learn/forest_prediction.h"
#include "passes/learn/history.h"

namespace sightline {
namespace {

constexpr double kSamePlace_m = 1e-3;

Result<void> check_inputs(const ErrorModel& model, const Sites& sites, const FactorTable& factors) {
  if (factors.site_count != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found factors of " + std::to_string(factors.site_count) + " sites, expected " +
                     std::to_string(sites.sites.size()),
                 "", ""};
  }
  if (factors.ranges_m != model.out_of_fold.ranges_m) {
    return Error{ErrorCode::kMismatchedInputs,
                 "factors and model are of different ranges; the model needs " +
                     std::to_string(model.ranges.size()) + " of " +
                     format_double(model.ranges.front().range_m) + " to " +
                     format_double(model.ranges.back().range_m) + " m",
                 "", ""};
  }
  return {};
}

std::vector<std::string> factors_of(const ErrorModel& model) {
  std::vector<std::string> names;
  for (const FeatureCard& feature : model.features) names.push_back(feature.name);
  names.pop_back();  // range_m is added to every row anyway
  std::erase_if(names, is_history_feature);
  return names;
}

// Sites of the model in order of x, to find those near a point without looking at all of them.
class TrainedPlaces {
 public:
  explicit TrainedPlaces(const std::vector<TrainedSite>& sites) : sites_(sites) {
    order_.resize(sites.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      const double ax = sites[a].p_world_m.x();
      const double bx = sites[b].p_world_m.x();
      return ax != bx ? ax < bx : a < b;
    });
  }
  // The case of this place with these features (the lowest index), or the number of cases.
  [[nodiscard]] std::size_t own(const Eigen::Vector3d& p_world_m, std::uint64_t digest) const {
    std::size_t found = sites_.size();
    visit(p_world_m, kSamePlace_m, [&](std::size_t site) {
      if (sites_[site].factor_digest == digest) found = std::min(found, site);
    });
    return found;
  }
  [[nodiscard]] bool is_near(const Eigen::Vector3d& p_world_m, double reach_m) const {
    bool found = false;
    visit(p_world_m, reach_m, [&](std::size_t) { found = true; });
    return found;
  }

 private:
  template <class Visit>
  void visit(const Eigen::Vector3d& p_world_m, double reach_m, const Visit& visit_site) const {
    const auto begin = std::lower_bound(
        order_.begin(), order_.end(), p_world_m.x() - reach_m,
        [&](std::size_t site, double x_m) { return sites_[site].p_world_m.x() < x_m; });
    for (auto i = begin; i != order_.end(); ++i) {
      if (sites_[*i].p_world_m.x() > p_world_m.x() + reach_m) break;
      if ((sites_[*i].p_world_m - p_world_m).norm() <= reach_m) visit_site(*i);
    }
  }

  const std::vector<TrainedSite>& sites_;
  std::vector<std::size_t> order_;
};

// A feature outside what training saw at its range, and by more than the margin.
bool is_outside_support(const ErrorModel& model, const FeatureRows& features, std::size_t row,
                        double margin) {
  const std::size_t range = row % model.ranges.size();
  for (std::size_t i = 0; i < model.features.size(); ++i) {
    const double least = model.features[i].support_min[range];
    const double greatest = model.features[i].support_max[range];
    const double slack = margin * (greatest - least);
    const double value = features.row(row)[i];
    if (value < least - slack || value > greatest + slack) return true;
  }
  return false;
}

// The rows that the model's forest expects. `told`: null where no earlier drive is known.
Result<FeatureRows> features_for(const ErrorModel& model, const FactorTable& factors,
                                 const History* told) {
  Result<FeatureRows> rows = gather_features(factors, factors_of(model));
  if (!rows || !model.card.knows_history) return rows;
  return with_history(*rows, told);
}

PredictedError whole_forest_prediction(const PassContext& ctx, double margin,
                                       const ErrorModel& model, const FeatureRows& features) {
  std::vector<std::uint32_t> rows(features.row_count);
  std::iota(rows.begin(), rows.end(), 0U);
  PredictedError predicted;
  predicted.ranges_m = model.out_of_fold.ranges_m;
  predicted.limits_m = model.out_of_fold.limits_m;
  predicted.support_margin = margin;
  predicted.site_count = static_cast<std::uint32_t>(features.row_count / model.ranges.size());
  ForestPrediction prediction =
      PreparedForest(model.forest, predicted.limits_m).predict(features, rows, ctx.threads);
  predicted.mean_m = std::move(prediction.mean);
  predicted.within_probability = std::move(prediction.within);
  predicted.extrapolated.assign(predicted.site_count, 0);
  predicted.out_of_fold.assign(predicted.site_count, 0);
  predicted.has_history.assign(predicted.site_count, 0);
  for (std::size_t row = 0; row < features.row_count; ++row) {
    if (is_outside_support(model, features, row, margin)) {
      predicted.extrapolated[row / model.ranges.size()] = 1;
    }
  }
  return predicted;
}

void take_out_of_fold(const ErrorModel& model, std::size_t trained, std::size_t site,
                      PredictedError& predicted) {
  const std::size_t mean_count = model.ranges.size();
  const std::size_t within_count = mean_count * predicted.limits_m.size();
  const auto copy = [&](const std::vector<double>& from, std::vector<double>& to,
                        std::size_t count) {
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(trained * count), count,
                to.begin() + static_cast<std::ptrdiff_t>(site * count));
  };
  copy(model.out_of_fold.mean_m, predicted.mean_m, mean_count);
  copy(model.out_of_fold.within_probability, predicted.within_probability, within_count);
  predicted.extrapolated[site] = model.out_of_fold.extrapolated[trained];
  predicted.out_of_fold[site] = 1;
}

// `told` is null, or of these sites.
Result<PredictedError> predict(const PassContext& ctx, const PredictErrorOptions& options,
                               const ErrorModel& model,
                               std::pair<const Sites&, const FactorTable&> map,
                               const History* told) {
  const auto& [sites, factors] = map;
  SIGHTLINE_ASSIGN(const FeatureRows features, features_for(model, factors, told));
  PredictedError predicted = whole_forest_prediction(ctx, options.support_margin, model, features);
  if (told != nullptr) predicted.has_history = told->is_known;
  const TrainedPlaces places(model.sites);
  std::size_t flattered_count = 0;
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    const Eigen::Vector3d p_world_m = sites.frame.origin_world_m + sites.sites[site].p_map_m;
    const std::uint64_t digest = features_digest(features, site, model.ranges.size());
    const std::size_t own = places.own(p_world_m, digest);
    if (own < model.sites.size()) {
      take_out_of_fold(model, own, site, predicted);
    } else if (places.is_near(p_world_m, model.card.buffer_m)) {
      ++flattered_count;
    }
  }
  if (flattered_count > 0) {
    ctx.warn(std::to_string(flattered_count) + " of " + std::to_string(sites.sites.size()) +
             " sites lie within " + format_double(model.card.buffer_m) +
             " m of where the model was trained, but are not its own sites: if this is the same "
             "place, the forest knows it, and predictions there may flatter");
  }
  return predicted;
}

}  // namespace

std::vector<OptionField> option_fields(PredictErrorOptions& options) {
  return {number("support_margin", options.support_margin,
                 "how far beyond the training's extremes a factor is still known, as a share of "
                 "their spread",
                 0.0, 10.0),
          choice("history", options.history,
                 "whether a model made elsewhere (--model) is told what the localization drive "
                 "measured here",
                 {"auto", "never"})};
}

Result<PredictedError> predict_error(PassContext& ctx, const PredictErrorOptions& options,
                                     const ErrorModel& model, const Sites& sites,
                                     const FactorTable& factors) {
  SIGHTLINE_TRY(check_inputs(model, sites, factors));
  return predict(ctx, options, model, {sites, factors}, nullptr);
}

Result<PredictedError> predict_error_with_history(PassContext& ctx,
                                                  const PredictErrorOptions& options,
                                                  const ErrorModel& model, const Sites& sites,
                                                  const FactorTable& factors,
                                                  const MeasuredError& history) {
  SIGHTLINE_TRY(check_inputs(model, sites, factors));
  if (history.scan_of_site.size() != sites.sites.size() || history.ranges_m != factors.ranges_m) {
    return Error{ErrorCode::kMismatchedInputs,
                 "the earlier drive was measured at other sites or ranges", "", ""};
  }
  if (!model.card.knows_history) {
    ctx.warn("the model was trained on places that were driven once: it cannot tell what drive '" +
             history.drive + "' measured here is worth, and does not use it");
    return predict(ctx, options, model, {sites, factors}, nullptr);
  }
  ctx.warn("the errors of drive '" + history.drive +
           "' are told to the model: figures judged on that drive flatter");
  const History told = history_of(sites, history);
  return predict(ctx, options, model, {sites, factors}, &told);
}

}  // namespace sightline
