#include "passes/model/own_evidence_model.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "formats/base/parallel.h"
#include "passes/model/forest/feature_rows.h"
#include "passes/model/forest/forest_prediction.h"
#include "passes/model/own_evidence.h"

namespace sightline {
namespace {

// Splits halfway between ranges, so that leaf i is range i: node i sends range i to the left.
RegressionTree tree_of_ranges(const std::vector<double>& ranges_m,
                              const std::vector<std::uint32_t>& range_of_label) {
  const auto node_count = static_cast<std::uint32_t>(ranges_m.size() - 1);
  RegressionTree tree;
  for (std::uint32_t i = 0; i < node_count; ++i) {
    const double between_m = (ranges_m[i] + ranges_m[i + 1]) / 2.0;
    const std::uint32_t right = i + 1 < node_count ? i + 1 : node_count + i + 1;
    tree.nodes.push_back({0, static_cast<float>(between_m), node_count + i, right});
  }
  tree.leaf_of_label = range_of_label;
  return tree;
}

// One tree; its rows are all sites at all ranges.
RegressionForest forest_of(const OwnEvidence& evidence) {
  std::vector<std::size_t> order(evidence.error_m.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return evidence.error_m[i]; });
  RegressionForest forest;
  forest.feature_count = 1;
  std::vector<std::uint32_t> range_of_label;
  for (const std::size_t i : order) {
    const std::size_t range = evidence.shape().row_of(i);
    forest.labels.push_back(evidence.error_m[i]);
    forest.rows.push_back(static_cast<float>(evidence.looks[range].range_m));
    range_of_label.push_back(static_cast<std::uint32_t>(range));
  }
  forest.trees.push_back(tree_of_ranges(ranges_of(evidence.looks), range_of_label));
  return forest;
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
  ForestPrediction prediction = PreparedForest(forest, limits_m).predict(features, rows, 1);
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
  if (sites.sites.empty()) return Error{ErrorCode::kNoTrainingRows, "there are no sites", "", ""};
  SIGHTLINE_ASSIGN(const OwnEvidence evidence, own_evidence_of(factors));
  SIGHTLINE_ASSIGN(const FeatureRows features, gather_features(factors, {}));
  ErrorModel model;
  model.card = card_of(sites, measured, recordings);
  model.forest = forest_of(evidence);
  const std::vector<double> ranges_m = ranges_of(evidence.looks);
  model.features = {{"range_m", 0.0, ranges_m, ranges_m}};
  model.ranges = range_cards(evidence);
  model.sites = sites_of(sites, features, evidence.looks.size());
  model.out_of_fold = predictions_of(model.forest, features, evidence, limits_m);
  model.measured_mean_m = evidence.error_m;
  return model;
}

}  // namespace sightline
