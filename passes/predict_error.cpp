#include "passes/predict_error.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "passes/learn/feature_rows.h"
#include "passes/learn/forest_prediction.h"

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
  // The nearest within reach_m (the lowest index on a tie), or the number of sites.
  [[nodiscard]] std::size_t nearest(const Eigen::Vector3d& p_world_m, double reach_m) const {
    std::size_t best = sites_.size();
    double best_m = reach_m;
    const auto begin = std::lower_bound(
        order_.begin(), order_.end(), p_world_m.x() - reach_m,
        [&](std::size_t site, double x_m) { return sites_[site].p_world_m.x() < x_m; });
    for (auto i = begin; i != order_.end(); ++i) {
      if (sites_[*i].p_world_m.x() > p_world_m.x() + reach_m) break;
      const double distance_m = (sites_[*i].p_world_m - p_world_m).norm();
      const bool is_nearer = distance_m < best_m || (distance_m == best_m && *i < best);
      if (!is_nearer) continue;
      best = *i;
      best_m = distance_m;
    }
    return best;
  }

 private:
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

PredictedError whole_forest_prediction(const PassContext& ctx, double margin,
                                       const ErrorModel& model, const FeatureRows& features) {
  std::vector<std::uint32_t> rows(features.row_count);
  std::iota(rows.begin(), rows.end(), 0U);
  PredictedError predicted;
  predicted.ranges_m = model.out_of_fold.ranges_m;
  predicted.limits_m = model.out_of_fold.limits_m;
  predicted.site_count = static_cast<std::uint32_t>(features.row_count / model.ranges.size());
  ForestPrediction prediction =
      PreparedForest(model.forest, predicted.limits_m).predict(features, rows, ctx.threads);
  predicted.mean_m = std::move(prediction.mean);
  predicted.within_probability = std::move(prediction.within);
  predicted.extrapolated.assign(predicted.site_count, 0);
  predicted.out_of_fold.assign(predicted.site_count, 0);
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

}  // namespace

std::vector<OptionField> option_fields(PredictErrorOptions& options) {
  return {number("support_margin", options.support_margin,
                 "how far beyond the training's extremes a factor is still known, as a share of "
                 "their spread",
                 0.0, 10.0)};
}

Result<PredictedError> predict_error(PassContext& ctx, const PredictErrorOptions& options,
                                     const ErrorModel& model, const Sites& sites,
                                     const FactorTable& factors) {
  const Result<void> checked = check_inputs(model, sites, factors);
  if (!checked) return checked.error();
  const Result<FeatureRows> features = gather_features(factors, factors_of(model));
  if (!features) return features.error();
  PredictedError predicted = whole_forest_prediction(ctx, options.support_margin, model, *features);
  const TrainedPlaces places(model.sites);
  std::size_t flattered_count = 0;
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    const Eigen::Vector3d p_world_m = sites.frame.origin_world_m + sites.sites[site].p_map_m;
    const std::size_t trained = places.nearest(p_world_m, kSamePlace_m);
    const bool is_own =
        trained < model.sites.size() &&
        model.sites[trained].factor_digest == features_digest(*features, site, model.ranges.size());
    if (is_own) {
      take_out_of_fold(model, trained, site, predicted);
    } else if (places.nearest(p_world_m, model.card.buffer_m) < model.sites.size()) {
      ++flattered_count;
    }
  }
  if (flattered_count > 0) {
    ctx.warn(std::to_string(flattered_count) + " of " + std::to_string(sites.sites.size()) +
             " sites lie within " + format_double(model.card.buffer_m) +
             " m of where the model was trained, but are not its own sites: the forest knows the "
             "place, and predictions there may flatter");
  }
  return predicted;
}

}  // namespace sightline
