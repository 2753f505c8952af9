#include "passes/train_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compiler/base/parallel.h"
#include "compiler/base/random.h"
#include "formats/table.h"
#include "passes/learn/out_of_fold.h"

namespace sightline {
namespace {

constexpr std::uint64_t kWholeForestKey = 0;

Result<void> check_inputs(const Sites& sites, const FactorTable& factors,
                          const MeasuredError& measured) {
  const std::size_t site_count = sites.sites.size();
  if (factors.site_count != site_count || measured.scan_of_site.size() != site_count) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found factors of " + std::to_string(factors.site_count) + " and errors of " +
                     std::to_string(measured.scan_of_site.size()) + " sites, expected " +
                     std::to_string(site_count),
                 "", ""};
  }
  if (factors.ranges_m != measured.ranges_m) {
    return Error{ErrorCode::kMismatchedInputs, "factors and errors are of different ranges", "",
                 ""};
  }
  return {};
}

Result<void> gather_labels(const MeasuredError& measured, Lesson& lesson) {
  const std::size_t range_count = measured.ranges_m.size();
  lesson.range_count = range_count;
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    const bool is_measured = measured.scan_of_site[site] >= 0;
    lesson.has_label.push_back(is_measured ? 1 : 0);
    for (std::size_t range = 0; range < range_count; ++range) {
      const double label = is_measured ? measured.row(site, range).mean_m : 0.0;
      if (!std::isfinite(label) || label < 0.0) {
        return Error{ErrorCode::kInvalidArtifact,
                     "found a mean error of " + format_double(label) + " m", "",
                     "site " + std::to_string(site) + ", range " +
                         format_double(measured.ranges_m[range]) + " m"};
      }
      lesson.labels.push_back(label);
    }
  }
  return {};
}

// What "all" means: every factor but a direction, which turns with the map's axes and tells a place
// nothing of its own.
std::vector<std::string> chosen_factors(const TrainModelOptions& options,
                                        const FactorTable& factors) {
  if (options.features == "paper") return paper_factors();
  std::vector<std::string> names = factors.factors;
  std::erase(names, "crlb_heading");
  return names;
}

// A drive with less route than two blocks still gets a map: shorter blocks judge it, and since they
// are not independent of each other, choose-ranges promises nothing on them.
Result<Folds> folds_of_route(const PassContext& ctx, const Sites& sites, const Lesson& lesson,
                             TrainModelOptions& options) {
  constexpr double kShortestBlock_m = 15.0;  // below this a block sees nothing but its neighbours
  Result<Folds> folds = make_folds(sites, lesson.has_label, {options.block_m, options.folds});
  if (folds || folds.error().code != ErrorCode::kDriveTooShort) return folds;
  if (options.block_m <= kShortestBlock_m) return folds;
  Result<Folds> short_folds =
      make_folds(sites, lesson.has_label, {kShortestBlock_m, options.folds});
  if (!short_folds) return folds;
  const double wanted_m = options.block_m;
  options.block_m = short_folds->labelled_route_m / short_folds->block_count;
  options.buffer_m = std::min(options.buffer_m, options.block_m / 2.0);
  ctx.warn("the drive is too short for two blocks of " + format_double(wanted_m) +
           " m: it is judged on " + std::to_string(short_folds->block_count) + " blocks of " +
           std::to_string(static_cast<int>(options.block_m)) +
           " m, whose figures flatter; nothing is promised");
  return short_folds;
}

// Lets `options` say what block and buffer were used.
Result<Lesson> prepare_lesson(const PassContext& ctx, TrainModelOptions& options,
                              const Sites& sites, const FactorTable& factors,
                              const MeasuredError& measured) {
  const Result<void> checked = check_inputs(sites, factors, measured);
  if (!checked) return checked.error();
  Lesson lesson;
  const Result<void> gathered = gather_labels(measured, lesson);
  if (!gathered) return gathered.error();
  Result<FeatureRows> features =
      gather_features(factors, chosen_factors(options, factors));
  if (!features) return features.error();
  lesson.features = std::move(*features);
  Result<Folds> folds = folds_of_route(ctx, sites, lesson, options);
  if (!folds) return folds.error();
  lesson.folds = std::move(*folds);
  return lesson;
}

// Least and greatest value of each feature among labelled rows, per range.
std::vector<FeatureCard> feature_cards(const Lesson& lesson,
                                       const std::vector<double>& importance) {
  std::vector<FeatureCard> cards(lesson.features.names.size());
  for (std::size_t feature = 0; feature < cards.size(); ++feature) {
    cards[feature].name = lesson.features.names[feature];
    cards[feature].importance_m = importance[feature];
    cards[feature].support_min.assign(lesson.range_count, std::numeric_limits<double>::infinity());
    cards[feature].support_max.assign(lesson.range_count, -std::numeric_limits<double>::infinity());
  }
  for (std::size_t row = 0; row < lesson.features.row_count; ++row) {
    if (lesson.has_label[row / lesson.range_count] == 0) continue;
    const std::size_t range = row % lesson.range_count;
    for (std::size_t feature = 0; feature < cards.size(); ++feature) {
      const double value = lesson.features.row(row)[feature];
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
    if (*least == *greatest) names += (names.empty() ? "" : ", ") + card.name;
  }
  if (!names.empty()) ctx.warn("factors that never vary teach nothing: " + names);
}

std::vector<RangeCard> range_cards(const Lesson& lesson, const PredictedError& predicted) {
  std::vector<RangeCard> cards;
  for (std::size_t range = 0; range < lesson.range_count; ++range) {
    std::vector<double> labels, squares, residuals;
    for (std::size_t site = 0; site < lesson.has_label.size(); ++site) {
      if (lesson.has_label[site] == 0) continue;
      const double label = lesson.labels[site * lesson.range_count + range];
      const double residual = predicted.mean(site, range) - label;
      labels.push_back(label);
      residuals.push_back(residual * residual);
    }
    const auto count = static_cast<double>(labels.size());
    const double mean = ordered_sum(labels) / count;
    for (const double label : labels) squares.push_back((label - mean) * (label - mean));
    const double total = ordered_sum(squares);
    const double left = ordered_sum(residuals);
    cards.push_back({predicted.ranges_m[range], mean, total > 0.0 ? 1.0 - left / total : 0.0,
                     std::sqrt(left / count)});
  }
  return cards;
}

std::vector<TrainedSite> trained_sites(const Sites& sites, const Lesson& lesson) {
  std::vector<TrainedSite> trained;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const Site& site = sites.sites[i];
    trained.push_back({sites.frame.origin_world_m + site.p_map_m, site.run, site.s_m,
                       lesson.folds.block_of_site[i], lesson.has_label[i],
                       features_digest(lesson.features, i, lesson.range_count)});
  }
  return trained;
}

TrainingCard training_card(const PassContext& ctx, const TrainModelOptions& options,
                           const MeasuredError& measured, const Folds& folds) {
  TrainingCard card;
  card.drive = measured.drive;
  card.reference = measured.reference;
  card.feature_set = options.features;
  card.seed = ctx.seed;
  card.tree_count = static_cast<std::uint32_t>(options.trees);
  card.least_leaf_rows = static_cast<std::uint32_t>(options.least_leaf_rows);
  card.feature_share = options.feature_share;
  card.block_m = options.block_m;
  card.buffer_m = options.buffer_m;
  card.labelled_route_m = folds.labelled_route_m;
  card.block_count = folds.block_count;
  card.fold_count = folds.fold_count;
  return card;
}

}  // namespace

std::vector<OptionField> option_fields(TrainModelOptions& options) {
  return {
      choice("features", options.features,
             "factors to learn from: the paper's eleven, or all there are", {"paper", "all"}),
      numbers("limits_m", options.limits_m, "accuracies that vehicles need, m", 0.001, 100.0),
      integer("trees", options.trees, "trees of the forest", 1, 10000),
      integer("least_leaf_rows", options.least_leaf_rows, "training rows in a leaf, at least", 1,
              1000),
      number("feature_share", options.feature_share, "share of the features tried at a split", 0.01,
             1.0),
      number("block_m", options.block_m,
             "route held out together, at least, m; below 60 nothing is promised", 5.0, 10000.0),
      number("buffer_m", options.buffer_m,
             "distance from held-out sites to what trains, m; below 25 nothing is promised", 0.0,
             1000.0),
      integer("folds", options.folds, "parts of the route that are held out in turn", 2, 100)};
}

Result<ErrorModel> train_model(PassContext& ctx, const TrainModelOptions& wanted,
                               const Sites& sites, const FactorTable& factors,
                               const MeasuredError& measured) {
  TrainModelOptions options = wanted;
  const Result<Lesson> lesson = prepare_lesson(ctx, options, sites, factors, measured);
  if (!lesson) return lesson.error();
  const ForestOptions forest_options{options.trees, options.least_leaf_rows, options.feature_share};
  PredictedError predicted;
  predicted.ranges_m = measured.ranges_m;
  predicted.limits_m = options.limits_m;
  Result<OutOfFold> out_of_fold = predict_out_of_fold(ctx, {forest_options, options.buffer_m},
                                                      sites, *lesson, std::move(predicted));
  if (!out_of_fold) return out_of_fold.error();
  const std::vector<std::uint8_t> leave_none_out(sites.sites.size(), 0);
  Result<RegressionForest> forest =
      grow_forest(lesson->features, labelled_rows(*lesson, leave_none_out), forest_options,
                  mix(ctx.seed, kWholeForestKey), ctx.threads);
  if (!forest) return forest.error();
  ErrorModel model;
  model.card = training_card(ctx, options, measured, lesson->folds);
  model.features = feature_cards(*lesson, out_of_fold->importance);
  warn_of_constant_factors(ctx, model.features);
  model.ranges = range_cards(*lesson, out_of_fold->predicted);
  model.forest = std::move(*forest);
  model.sites = trained_sites(sites, *lesson);
  model.out_of_fold = std::move(out_of_fold->predicted);
  model.measured_mean_m = lesson->labels;
  return model;
}

}  // namespace sightline
