#include "passes/model/own_evidence_model.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "formats/base/parallel.h"
#include "passes/model/choice/own_evidence.h"
#include "passes/model/forest/forest_prediction.h"
#include "passes/model/forest/growing/feature_rows.h"

namespace sightline {
namespace {

// What distinguishes looks: its number where it has one, since looks that take a sample
// may all reach equally far; else its range.
constexpr const char* kLookNumber = "look_number";

Result<FeatureRows> features_of_looks(const FactorTable& factors) {
  const bool has_number = std::ranges::find(factors.factors, kLookNumber) != factors.factors.end();
  return gather_features(
      factors, has_number ? std::vector<std::string>{kLookNumber} : std::vector<std::string>{});
}

// Splits the first feature halfway between looks, so that leaf i is look i: node i sends look i to
// the left. Features of the first site stand for all.
RegressionTree tree_of_looks(const FeatureRows& features, std::size_t look_count) {
  const auto node_count = static_cast<std::uint32_t>(look_count - 1);
  RegressionTree tree;
  for (std::uint32_t i = 0; i < node_count; ++i) {
    const float between = (features.row(i)[0] + features.row(i + 1)[0]) / 2.0F;
    const std::uint32_t right = i + 1 < node_count ? i + 1 : node_count + i + 1;
    tree.nodes.push_back({0, between, node_count + i, right});
  }
  return tree;
}

// One tree; its rows are all sites at all looks.
RegressionForest forest_of(const OwnEvidence& evidence, const FeatureRows& features) {
  std::vector<std::size_t> order(evidence.error_m.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return evidence.error_m[i]; });
  RegressionForest forest;
  forest.feature_count = static_cast<std::uint32_t>(features.names.size());
  for (const std::size_t i : order) {
    const std::size_t look = evidence.shape().row_of(i);
    forest.labels.push_back(evidence.error_m[i]);
    forest.rows.insert(forest.rows.end(), features.row(look),
                       features.row(look) + features.names.size());
  }
  forest.trees.push_back(tree_of_looks(features, evidence.looks.size()));
  return forest;
}

// Each look is where training saw it, and nowhere else.
std::vector<FeatureCard> feature_cards(const FeatureRows& features, std::size_t look_count) {
  std::vector<FeatureCard> cards;
  for (std::size_t f = 0; f < features.names.size(); ++f) {
    FeatureCard& card = cards.emplace_back();
    card.name = features.names[f];
    for (std::size_t look = 0; look < look_count; ++look) {
      card.support_min.push_back(features.row(look)[f]);
    }
    card.support_max = card.support_min;
  }
  return cards;
}

std::vector<TrainedSite> sites_of(const Sites& sites, const FeatureRows& features,
                                  std::size_t range_count) {
  std::vector<TrainedSite> trained;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    TrainedSite site;
    site.p_world_m = sites.frame.origin_world_m + sites.sites[i].p_map_m;
    site.run = sites.sites[i].run;
    site.s_m = sites.sites[i].s_m;
    site.has_label = 1;
    site.factor_digest = features_digest(features, i, range_count);
    trained.push_back(site);
  }
  return trained;
}

TrainingCard card_of(const Sites& sites, const MeasuredError& measured,
                     const RecordingCards& recordings) {
  const double route_m = static_cast<double>(sites.sites.size()) * sites.spacing_m;
  TrainingCard card;
  card.places = {{measured.drive, {measured.drive}, route_m, 1, recordings}};
  card.reference = measured.reference;
  card.localizer = measured.matching.localizer;
  card.feature_set = "none";
  card.hold_out = "blocks";
  card.tree_count = 1;
  card.least_leaf_rows = 1;
  card.feature_share = 1.0;
  card.block_m = card.labelled_route_m = route_m;
  card.block_count = 1;
  return card;
}

// What the one tree says of every site, its own labels included: there is nothing held out.
PredictedError predictions_of(const RegressionForest& forest, const FeatureRows& features,
                              const OwnEvidence& evidence, const std::vector<double>& limits_m) {
  std::vector<std::uint32_t> rows(features.row_count);
  std::iota(rows.begin(), rows.end(), 0U);
  ForestPrediction prediction = PreparedForest(forest, limits_m, 1).predict(features, rows, 1);
  PredictedError predicted;
  predicted.looks = evidence.looks;
  predicted.limits_m = limits_m;
  predicted.site_count = evidence.site_count;
  predicted.mean_m = std::move(prediction.mean);
  predicted.within_probability = std::move(prediction.within);
  predicted.extrapolated.assign(predicted.mean_m.size(), 0);
  predicted.out_of_fold.assign(predicted.site_count, 1);
  predicted.has_history.assign(predicted.site_count, 0);
  return predicted;
}

std::vector<RangeCard> range_cards(const OwnEvidence& evidence) {
  std::vector<RangeCard> cards;
  for (std::size_t range = 0; range < evidence.looks.size(); ++range) {
    std::vector<double> errors_m;
    for (std::size_t site = 0; site < evidence.site_count; ++site) {
      errors_m.push_back(evidence.error_m[evidence.shape().index(site, range)]);
    }
    const double mean_m = ordered_sum(errors_m) / static_cast<double>(errors_m.size());
    cards.push_back({evidence.looks[range].range_m, mean_m});
  }
  return cards;
}

}  // namespace

Result<ErrorModel> model_of_own_evidence(const Sites& sites, const FactorTable& factors,
                                         const MeasuredError& measured,
                                         const RecordingCards& recordings,
                                         const std::vector<double>& limits_m) {
  if (sites.sites.empty()) return Error{ErrorCode::kNoTrainingRows, "there are no sites"};
  SIGHTLINE_ASSIGN(const OwnEvidence evidence, own_evidence_of(factors));
  SIGHTLINE_ASSIGN(const FeatureRows features, features_of_looks(factors));
  ErrorModel model;
  model.card = card_of(sites, measured, recordings);
  model.forest = forest_of(evidence, features);
  model.features = feature_cards(features, evidence.looks.size());
  model.ranges = range_cards(evidence);
  model.sites = sites_of(sites, features, evidence.looks.size());
  model.out_of_fold = predictions_of(model.forest, features, evidence, limits_m);
  model.measured_mean_m = evidence.error_m;
  return model;
}

}  // namespace sightline
