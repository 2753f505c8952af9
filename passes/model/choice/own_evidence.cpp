#include "passes/model/choice/own_evidence.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/grid/point_grid.h"
#include "passes/model/forest/folds.h"
#include "passes/model/forest/forest_prediction.h"
#include "passes/model/forest/growing/feature_rows.h"

namespace sightline {
namespace {

// Shares of sites that are equal may differ in their last bit.
constexpr double kRounding = 1e-12;

std::optional<std::size_t> column_of(const FactorTable& factors, std::string_view name) {
  const auto found = std::ranges::find(factors.factors, name);
  if (found == factors.factors.end()) return std::nullopt;
  return static_cast<std::size_t>(found - factors.factors.begin());
}

std::vector<double> values_of(const FactorTable& factors, std::size_t column) {
  std::vector<double> values;
  values.reserve(factors.looks.size() * factors.site_count);
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (std::size_t range = 0; range < factors.looks.size(); ++range) {
      values.push_back(factors.at(site, range, column));
    }
  }
  return values;
}

std::vector<double> cost_of(const FactorTable& factors) {
  for (const char* name : {"match_cost", "virtual_points"}) {
    const std::optional<std::size_t> column = column_of(factors, name);
    if (column) return values_of(factors, *column);
  }
  std::vector<double> cost;
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (const Look& look : factors.looks) cost.push_back(look.range_m);
  }
  return cost;
}

// Recordings without coordinates of the world all begin at 0: the site's prediction decides whether
// a case of the model that lies there is its own.
bool is_of_case(const PredictedError& predicted, std::size_t site, const ErrorModel& model,
                std::size_t trained) {
  if (model.sites[trained].has_label == 0) return false;
  for (std::size_t range = 0; range < predicted.looks.size(); ++range) {
    if (model.out_of_fold.mean(trained, range) != predicted.mean(site, range)) return false;
  }
  return true;
}

// Over all sites at one range.
double sum_of_errors_m(const OwnEvidence& evidence, std::size_t range) {
  std::vector<double> errors_m;
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    errors_m.push_back(evidence.error_m[evidence.shape().index(site, range)]);
  }
  return ordered_sum(errors_m);
}

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
  card.places.front().recording_numbers = origins_by_recording({&recordings}).recordings.front();
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
    cards.push_back({evidence.looks[range].range_m,
                     sum_of_errors_m(evidence, range) / static_cast<double>(evidence.site_count)});
  }
  return cards;
}

}  // namespace

Result<OwnEvidence> own_evidence_of(const FactorTable& factors) {
  std::optional<std::size_t> column;
  for (const char* name : {"own_error", "mapping_error", "virtual_error"}) {
    if (!column) column = column_of(factors, name);
  }
  if (!column) {
    return Error{ErrorCode::kMismatchedInputs,
                 "the factors contain none of own_error, mapping_error and virtual_error: the "
                 "localization error of the map's own scans is unknown"};
  }
  return OwnEvidence{factors.looks, factors.site_count, values_of(factors, *column),
                     cost_of(factors), is_simulated(factors)};
}

Result<OwnEvidence> own_evidence_of(const StoredTable<FactorTable>& all) {
  OwnEvidence evidence;
  const std::size_t site_count = all.row_count();
  for (std::size_t first = 0; first == 0 || first < site_count; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, site_count - first);
    SIGHTLINE_ASSIGN(const FactorTable some, all.rows(first, count));
    SIGHTLINE_ASSIGN(const OwnEvidence here, own_evidence_of(some));
    evidence.looks = here.looks;
    evidence.site_count += here.site_count;
    evidence.error_m.insert(evidence.error_m.end(), here.error_m.begin(), here.error_m.end());
    evidence.cost.insert(evidence.cost.end(), here.cost.begin(), here.cost.end());
    evidence.is_simulated = here.is_simulated;
  }
  return evidence;
}

void add_measured(const Sites& sites, const PredictedError& predicted, const ErrorModel& model,
                  OwnEvidence& evidence) {
  constexpr double kSamePlace_m = 1e-3;
  std::vector<Eigen::Vector3d> places_m;
  for (const TrainedSite& site : model.sites) places_m.push_back(site.p_world_m);
  const PointGrid grid(places_m);
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    if (predicted.out_of_fold[site] == 0) continue;
    const Eigen::Vector3d p_world_m = sites.frame.origin_world_m + sites.sites[site].p_map_m;
    grid.visit_within(p_world_m, kSamePlace_m, [&](const NearPoint& near) {
      if (!is_of_case(predicted, site, model, near.index)) return;
      for (std::size_t range = 0; range < evidence.looks.size(); ++range) {
        double& error_m = evidence.error_m[evidence.shape().index(site, range)];
        error_m = std::max(error_m, model.measured(near.index, range));
      }
    });
  }
}

OwnEvidence for_another_localizer(OwnEvidence evidence) {
  const std::size_t range_count = evidence.looks.size();
  for (std::size_t i = 0; i < evidence.error_m.size(); ++i) {
    const bool is_longest = i % range_count == range_count - 1;
    evidence.error_m[i] = is_longest ? 0.0 : std::numeric_limits<double>::infinity();
  }
  return evidence;
}

Standing standing_of(const OwnEvidence& evidence, double limit_m,
                     const std::vector<std::uint8_t>& range_index) {
  std::vector<double> within;
  std::vector<double> costs;
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    const std::size_t i = evidence.shape().index(site, range_index[site]);
    within.push_back(evidence.error_m[i] <= limit_m ? 1.0 : 0.0);
    costs.push_back(evidence.cost[i]);
  }
  const double count = std::max<double>(1.0, evidence.site_count);
  return {ordered_sum(within) / count, ordered_sum(costs) / count};
}

StaticAnswer best_static(const OwnEvidence& evidence, double limit_m, double least_coverage) {
  std::vector<StaticAnswer> answers;
  double most = 0.0;
  for (std::size_t range = 0; range < evidence.looks.size(); ++range) {
    const auto index = static_cast<std::uint8_t>(range);
    const std::vector<std::uint8_t> everywhere(evidence.site_count, index);
    answers.push_back({index, standing_of(evidence, limit_m, everywhere)});
    most = std::max(most, answers.back().standing.coverage);
  }
  if (most <= 0.0) {
    return *std::ranges::min_element(answers, {}, [&](const StaticAnswer& a) {
      return sum_of_errors_m(evidence, a.range_index);
    });
  }
  const double enough = std::min(least_coverage, most) - kRounding;
  std::erase_if(answers, [&](const StaticAnswer& a) { return a.standing.coverage < enough; });
  return *std::ranges::min_element(answers, {},
                                   [](const StaticAnswer& a) { return a.standing.cost; });
}

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
