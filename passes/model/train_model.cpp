#include "passes/model/train_model.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "formats/model/place_count.h"
#include "formats/text/table.h"
#include "passes/model/choice/own_evidence.h"
#include "passes/model/forest/forest_prediction.h"
#include "passes/model/forest/out_of_fold.h"
#include "passes/model/forest/training_set.h"
#include "passes/model/training_cards.h"

namespace sightline {
namespace {

constexpr std::uint64_t kWholeForestKey = 0;

// A drive with less route than two blocks still gets a map: shorter blocks judge it, and since they
// are not independent of each other, choose-ranges promises nothing on them. Lets `options` say
// what block and buffer were used.
Result<TrainingSet> prepare_training_set(const PassContext& ctx, const DrivenPlaces& places,
                                         TrainModelOptions& options) {
  constexpr double kShortestBlock_m = 15.0;  // below this a block sees nothing but its neighbours
  TrainingSetOptions wanted{options.features, options.block_m, options.folds, options.hold_out};
  Result<TrainingSet> training_set = make_training_set(wanted, places);
  if (training_set || training_set.error().code != ErrorCode::kDriveTooShort) return training_set;
  if (options.block_m <= kShortestBlock_m) return training_set;
  wanted.block_m = kShortestBlock_m;
  SIGHTLINE_ASSIGN(TrainingSet smaller_blocks, make_training_set(wanted, places));
  const std::string wanted_m = format_double(options.block_m);
  options.block_m = smaller_blocks.folds.labelled_route_m / smaller_blocks.folds.block_count();
  options.buffer_m = std::min(options.buffer_m, options.block_m / 2.0);
  ctx.warn(concat("the drive is too short for two blocks of ", wanted_m,
                  " m: it is cross-validated on ", smaller_blocks.folds.block_count(),
                  " blocks of ", static_cast<int>(options.block_m),
                  " m, whose figures are optimistic, and there is no promise. A promise needs a "
                  "model of other drives with 1.2 km of route: `sightline train` makes it"));
  return smaller_blocks;
}

TrainingCard training_card(const PassContext& ctx, const TrainModelOptions& options,
                           const TrainingSet& training_set, const MeasuredError& any_drive) {
  TrainingCard card;
  card.places = training_set.places;
  card.reference = any_drive.reference;
  card.localizer = any_drive.matching.localizer;
  card.feature_set = options.features == FeatureSet::kPaper ? "paper" : "all";
  card.hold_out = hold_out_name(training_set.held_out);
  card.seed = ctx.seed;
  card.tree_count = static_cast<std::uint32_t>(options.trees);
  card.least_leaf_rows = static_cast<std::uint32_t>(options.least_leaf_rows);
  card.feature_share = options.feature_share;
  card.block_m = options.block_m;
  card.buffer_m = options.buffer_m;
  card.labelled_route_m = training_set.folds.labelled_route_m;
  card.block_count = training_set.folds.block_count();
  card.fold_count = training_set.folds.fold_count;
  card.knows_history = training_set.knows_history;
  if (options.worlds == TrainingWorlds::kGenerated) card.worlds = "generated";
  return card;
}

ForestOptions forest_options(const TrainModelOptions& options) {
  return {options.trees, options.least_leaf_rows, options.feature_share, options.tree_rows};
}

LabelledRows rows_of_whole_forest(const TrainModelOptions& options,
                                  const TrainingSet& training_set) {
  const std::vector<std::uint8_t> leave_none_out(training_set.sites.size(), 0);
  return labelled_rows(training_set, leave_none_out, static_cast<std::size_t>(options.most_rows));
}

Result<RegressionForest> grow_whole_forest(const PassContext& ctx, const TrainModelOptions& options,
                                           const TrainingSet& training_set) {
  return grow_forest(training_set.features, rows_of_whole_forest(options, training_set),
                     forest_options(options), mix(ctx.seed, kWholeForestKey), ctx.threads);
}

// To whole steps, of which so many are 1: they take half the space in a packed model.
float rounded(double value, double steps) {
  return static_cast<float>(std::round(value * steps) / steps);
}

// `predicted`: by trees that never saw the place. Takes the labels of the training set.
TrackingLabels tracking_labels(const TrainModelOptions& options, TrainingSet& training_set,
                               const ForestPrediction& predicted) {
  constexpr double kShareSteps = 4096.0;
  constexpr double kMetreSteps = 1024.0;
  TrackingLabels tracking;
  if (training_set.tracking_labels_m.empty()) return tracking;
  for (const std::uint32_t row :
       sorted_by_label(rows_of_whole_forest(options, training_set)).rows) {
    tracking.row_errors_m.push_back(training_set.tracking_labels_m[row]);
  }
  tracking.curve =
      fit_curve(predicted_tracking_shares(training_set, predicted.within, options.limits_m));
  for (const double mean_m : predicted.mean)
    tracking.mean_m.push_back(rounded(mean_m, kMetreSteps));
  for (const double share : predicted.within) {
    tracking.within_probability.push_back(rounded(on_curve(tracking.curve, share), kShareSteps));
  }
  tracking.measured_m = std::move(training_set.tracking_labels_m);
  return tracking;
}

// [case]: by the factors of ranges, as in maps. The factors of looks that take a sample are all of
// one range, and show no walls nearer than that.
using CaseKinds = std::vector<PlaceKind>;

// Takes the places, which are let go once they are rows. `kinds` is set by the ranges, which come
// first, and used by the looks that take a sample.
Result<ErrorModel> train_on(PassContext& ctx, const TrainModelOptions& wanted, DrivenPlaces places,
                            CaseKinds& kinds) {
  TrainModelOptions options = wanted;
  SIGHTLINE_ASSIGN(TrainingSet training_set, prepare_training_set(ctx, places, options));
  for (std::size_t i = 0; i < training_set.sites.size(); ++i) {
    if (kinds.size() == i) kinds.push_back(training_set.sites[i].kind);
    training_set.sites[i].kind = kinds[i];
  }
  ErrorModel model;
  model.card = training_card(ctx, options, training_set, places.places.front().drives.front());
  PredictedError predicted;
  predicted.looks = places.places.front().factors.looks;
  predicted.limits_m = options.limits_m;
  places = {};
  const OutOfFoldOptions out_of_fold_options{forest_options(options), options.buffer_m,
                                             static_cast<std::size_t>(options.most_rows)};
  SIGHTLINE_ASSIGN(OutOfFold out_of_fold, predict_out_of_fold(ctx, out_of_fold_options,
                                                              training_set, std::move(predicted)));
  SIGHTLINE_ASSIGN(RegressionForest forest, grow_whole_forest(ctx, options, training_set));
  model.card.curve = fit_curve(predicted_shares(training_set, out_of_fold.predicted));
  put_on_curve(model.card.curve, out_of_fold.predicted);
  // From here on P(error <= limit) is what came true out of fold.
  model.features = feature_cards(training_set, out_of_fold.importance);
  warn_of_constant_factors(ctx, model.features);
  model.ranges = range_cards(training_set, out_of_fold.predicted);
  model.kinds = kind_cards(training_set, out_of_fold.predicted);
  model.forest = std::move(forest);
  for (std::size_t i = 0; i < training_set.sites.size(); ++i) {
    training_set.sites[i].factor_digest =
        features_digest(training_set.features, i, training_set.range_count);
  }
  model.tracking = tracking_labels(options, training_set, out_of_fold.tracking);
  model.sites = std::move(training_set.sites);
  model.out_of_fold = std::move(out_of_fold.predicted);
  model.measured_mean_m = std::move(training_set.labels);
  return model;
}

}  // namespace

std::vector<OptionField> option_fields(TrainModelOptions& options) {
  return {
      choice("features", options.features, "factors to train on: the eleven of the paper, or all",
             {"paper", "all"}),
      shared(numbers("limits_m", options.limits_m, "localization errors that vehicles accept, m",
                     0.001, 100.0)),
      integer("trees", options.trees, "trees in the forest", 1, 10000),
      integer("least_leaf_rows", options.least_leaf_rows, "least training rows in a leaf", 1, 1000),
      number("feature_share", options.feature_share,
             "share of the features that are tried at a split", 0.01, 1.0),
      integer("tree_rows", options.tree_rows,
              "most rows that one tree is grown on, drawn separately for each tree", 100,
              10'000'000),
      number("block_m", options.block_m,
             "least route in a held-out block, m; below 60 there is no promise", 5.0, 10000.0),
      number("buffer_m", options.buffer_m,
             "distance from held-out sites to training sites, m; below 25 there is no promise", 0.0,
             1000.0),
      integer("folds", options.folds, "parts of the route for cross-validation", 2, 100),
      choice(
          "hold_out", options.hold_out,
          "held out together: blocks of route (no promise for the next drive), blocks of one drive "
          "predicted by the other drives, whole places, or (auto) places where two have different "
          "recordings, else drives where there are two",
          {"auto", "blocks", "drives", "places"}),
      integer(
          "most_rows", options.most_rows,
          "most rows that one forest is trained on; of more, every second, third, ... site is used",
          1000, 10'000'000),
      choice(
          "worlds", options.worlds,
          "whether the drives were recorded, or generated by a program: what a model of generated "
          "worlds predicts is marked so, and it gives no promise",
          {"recorded", "generated"})};
}

namespace {

// Whose progress counts the families of looks one after the other, each with the same total.
PassContext counting_families(const PassContext& ctx, bool has_samples) {
  PassContext counting = ctx;
  if (!ctx.progress_sink || !has_samples) return counting;
  counting.progress_sink = [sink = ctx.progress_sink, first = std::size_t{0},
                            last = std::size_t{0}](std::size_t done, std::size_t total) mutable {
    if (done <= last) first += total;  // the next family
    last = done;
    sink(first + done, 2 * total);
  };
  return counting;
}

void warn_of_one_place(const PassContext& ctx, const TrainingCard& card) {
  if (place_count(card) > 1) return;
  const std::string same = card.places.size() > 1 ? places_text(card) : "one place";
  ctx.warn(concat("the model is trained on ", same,
                  ": maps of other places get no promise; train it on two places or more"));
}

}  // namespace

Result<ByFamily<ErrorModel>> train_model(PassContext& ctx, const TrainModelOptions& wanted,
                                         const ByFamily<DrivenPlaces>& places) {
  PassContext of_families = counting_families(ctx, places.samples.has_value());
  CaseKinds kinds;
  const auto of_family = [&](const DrivenPlaces& family) {
    return train_on(of_families, wanted, family, kinds);
  };
  SIGHTLINE_ASSIGN(ByFamily<ErrorModel> model, each_family(of_family, places));
  warn_of_one_place(ctx, model.ranges.card);
  return model;
}

namespace {

// A place by the looks of a family, its tables stored: of two models that learn from it, each takes
// what it needs when it needs it.
struct PlaceInUse {
  std::string name;
  const Sites* sites = nullptr;
  StoredTable<FactorTable> factors;
  std::vector<StoredTable<MeasuredError>> drives;
  RecordingCards recordings;
};

Result<ByFamily<PlaceInUse>> place_in_use(
    const Sites& sites, const ByFamily<StoredTable<FactorTable>>& factors,
    const std::vector<ByFamily<StoredTable<MeasuredError>>>& drives,
    const RecordingCards& recordings) {
  const auto of_family =
      [&](const StoredTable<FactorTable>& table,
          const std::vector<StoredTable<MeasuredError>>& measured) -> Result<PlaceInUse> {
    return PlaceInUse{measured.front().head().drive, &sites, table, measured, recordings};
  };
  return each_family(of_family, factors, join_families(drives));
}

// Error: cannot-read.
Result<DrivenPlace> whole_place(const PlaceInUse& place) {
  SIGHTLINE_ASSIGN(FactorTable factors, place.factors.whole());
  DrivenPlace found{place.name, *place.sites, std::move(factors), {}, place.recordings};
  for (const StoredTable<MeasuredError>& drive : place.drives) {
    SIGHTLINE_ASSIGN(MeasuredError of_drive, drive.whole());
    found.drives.push_back(std::move(of_drive));
  }
  return found;
}

// What the map's own scans say.
Result<ByFamily<ErrorModel>> own_evidence_of(const std::vector<double>& limits_m,
                                             const ByFamily<PlaceInUse>& in_use) {
  const auto of_family = [&](const PlaceInUse& family) -> Result<ErrorModel> {
    SIGHTLINE_ASSIGN(const DrivenPlace place, whole_place(family));
    return model_of_own_evidence(place.sites, place.factors, place.drives.front(), place.recordings,
                                 limits_m);
  };
  return each_family(of_family, in_use);
}

// From one place; where that is too little, what its own scans say.
Result<ByFamily<ErrorModel>> learn_here(PassContext& ctx, const TrainModelOptions& wanted,
                                        const ByFamily<PlaceInUse>& place) {
  PassContext of_families = counting_families(ctx, place.samples.has_value());
  CaseKinds kinds;
  const auto of_family = [&](const PlaceInUse& family) -> Result<ErrorModel> {
    DrivenPlaces places;
    SIGHTLINE_ASSIGN(places.places.emplace_back(), whole_place(family));
    return train_on(of_families, wanted, std::move(places), kinds);
  };
  Result<ByFamily<ErrorModel>> model = each_family(of_family, place);
  const bool is_too_short = !model && (model.error().code == ErrorCode::kDriveTooShort ||
                                       model.error().code == ErrorCode::kNoTrainingRows);
  if (!is_too_short) return model;
  Result<ByFamily<ErrorModel>> own = own_evidence_of(wanted.limits_m, place);
  if (!own) return model;
  ctx.warn(concat("there is too little data to train on (", model.error().message,
                  "). One range, from the errors of the map's own scans, is used everywhere, "
                  "without a promise"));
  return own;
}

}  // namespace

Result<ByFamily<ErrorModel>> train_model_here(PassContext& ctx, const TrainModelOptions& wanted,
                                              const Sites& sites,
                                              const ByFamily<StoredTable<FactorTable>>& factors,
                                              const ByFamily<StoredTable<MeasuredError>>& measured,
                                              const RecordingCards& recordings,
                                              const MeasuredDrives* drives) {
  if (drives != nullptr && drives->drives.empty()) {
    return Error{
        ErrorCode::kNoTrainingRows,
        "no localization drive has a scan near a site. Check that it follows the mapped route"};
  }
  if (drives != nullptr) {
    SIGHTLINE_ASSIGN(const ByFamily<PlaceInUse> of_all,
                     place_in_use(sites, factors, {drives->drives.begin(), drives->drives.end()},
                                  without_left_out(recordings, *drives)));
    return learn_here(ctx, wanted, of_all);
  }
  SIGHTLINE_ASSIGN(const ByFamily<PlaceInUse> place,
                   place_in_use(sites, factors, {measured}, recordings));
  // A forest that learnt simulated errors predicts simulated errors.
  if (measured.ranges.head().reference == ErrorReference::kSimulated) {
    return own_evidence_of(wanted.limits_m, place);
  }
  return learn_here(ctx, wanted, place);
}

}  // namespace sightline
