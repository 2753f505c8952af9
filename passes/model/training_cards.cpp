#include "passes/model/training_cards.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"
#include "formats/base/statistics.h"
#include "passes/model/promise/selection.h"

namespace sightline {
namespace {

struct Fit {
  double mean_label_m = 0.0;
  double r_squared = 0.0;
  double rmse_m = 0.0;
};

// Of the out-of-fold means at one range, over the cases with or without history.
Fit fit_at(const TrainingSet& training_set, const PredictedError& predicted, std::size_t range,
           std::uint8_t has_history) {
  std::vector<double> labels, squares, residuals;
  for (std::size_t i = 0; i < training_set.sites.size(); ++i) {
    if (training_set.sites[i].has_label == 0 || training_set.sites[i].has_history != has_history)
      continue;
    const double label = training_set.labels[training_set.shape().index(i, range)];
    const double residual = predicted.mean(i, range) - label;
    labels.push_back(label);
    residuals.push_back(residual * residual);
  }
  if (labels.empty()) return {};
  const auto count = static_cast<double>(labels.size());
  const double mean = ordered_sum(labels) / count;
  for (const double label : labels) squares.push_back((label - mean) * (label - mean));
  const double total = ordered_sum(squares);
  const double left = ordered_sum(residuals);
  return {mean, total > 0.0 ? 1.0 - left / total : 0.0, std::sqrt(left / count)};
}

// The labelled cases of one kind of place, without earlier drives.
std::vector<std::size_t> cases_in(const TrainingSet& training_set, PlaceKind kind) {
  std::vector<std::size_t> cases;
  for (std::size_t i = 0; i < training_set.sites.size(); ++i) {
    const TrainedSite& site = training_set.sites[i];
    if (site.has_label == 1 && site.has_history == 0 && site.kind == kind) cases.push_back(i);
  }
  return cases;
}

}  // namespace

std::vector<FeatureCard> feature_cards(const TrainingSet& training_set,
                                       const std::vector<double>& importance) {
  std::vector<FeatureCard> cards(training_set.features.names.size());
  for (std::size_t feature = 0; feature < cards.size(); ++feature) {
    cards[feature].name = training_set.features.names[feature];
    cards[feature].importance_m = importance[feature];
    cards[feature].support_min.assign(training_set.range_count,
                                      std::numeric_limits<double>::infinity());
    cards[feature].support_max.assign(training_set.range_count,
                                      -std::numeric_limits<double>::infinity());
  }
  for (std::size_t row = 0; row < training_set.features.row_count; ++row) {
    if (training_set.sites[training_set.shape().site_of(row)].has_label == 0) continue;
    const std::size_t range = training_set.shape().row_of(row);
    for (std::size_t feature = 0; feature < cards.size(); ++feature) {
      const double value = training_set.features.row(row)[feature];
      double& least = cards[feature].support_min[range];
      double& greatest = cards[feature].support_max[range];
      least = std::min(least, value);
      greatest = std::max(greatest, value);
    }
  }
  return cards;
}

void warn_of_constant_factors(const PassContext& ctx, const std::vector<FeatureCard>& cards) {
  std::string names;
  for (const FeatureCard& card : cards) {
    const auto least = std::min_element(card.support_min.begin(), card.support_min.end());
    const auto greatest = std::max_element(card.support_max.begin(), card.support_max.end());
    // Looks that take a sample may all reach equally far, and a mark is there to be the same.
    const bool may_be_constant = card.name == "range_m" || card.name == kSimulatedColumn;
    if (*least == *greatest && !may_be_constant) names += (names.empty() ? "" : ", ") + card.name;
  }
  if (!names.empty()) ctx.inform("factors that are constant are not used: " + names);
}

std::vector<RangeCard> range_cards(const TrainingSet& training_set,
                                   const PredictedError& predicted) {
  std::vector<RangeCard> cards;
  for (std::size_t range = 0; range < training_set.range_count; ++range) {
    const Fit map_only = fit_at(training_set, predicted, range, 0);
    const Fit with_history = fit_at(training_set, predicted, range, 1);
    cards.push_back({predicted.looks[range].range_m, map_only.mean_label_m, map_only.r_squared,
                     map_only.rmse_m, with_history.r_squared, with_history.rmse_m});
  }
  return cards;
}

std::vector<KindCard> kind_cards(const TrainingSet& training_set, const PredictedError& predicted) {
  std::vector<KindCard> cards;
  for (const double limit_m : predicted.limits_m) {
    const Choice choice = choose_by_mean(predicted, limit_m);
    for (std::size_t type = 1; type < kPlaceKindCount; ++type) {
      const std::vector<std::size_t> cases = cases_in(training_set, static_cast<PlaceKind>(type));
      if (cases.empty()) continue;
      std::vector<double> met, ranges, errors;
      for (const std::size_t i : cases) {
        const std::size_t range = choice.range_index[i];
        errors.push_back(training_set.labels[training_set.shape().index(i, range)]);
        ranges.push_back(predicted.looks[range].range_m);
        met.push_back(errors.back() <= limit_m ? 1.0 : 0.0);
      }
      cards.push_back({limit_m, static_cast<PlaceKind>(type),
                       static_cast<std::uint32_t>(cases.size()), mean_of(met), mean_of(ranges),
                       mean_of(errors)});
    }
  }
  return cards;
}

}  // namespace sightline
