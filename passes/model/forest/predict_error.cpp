#include "passes/model/forest/predict_error.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "formats/drive/shared_scans.h"
#include "formats/grid/point_grid.h"
#include "passes/model/forest/forest_prediction.h"
#include "passes/model/forest/growing/feature_rows.h"
#include "passes/model/forest/history.h"

namespace sightline {
namespace {

constexpr double kSamePlace_m = 1e-3;

// `factors` may be without values.
Result<void> check_inputs(const ErrorModel& model, const Sites& sites, const FactorTable& factors) {
  if (factors.site_count != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs, concat("found factors of ", factors.site_count,
                                                      " sites, expected ", sites.sites.size())};
  }
  if (factors.looks != model.out_of_fold.looks) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat("factors and model are of different ranges; the model needs ",
                        model.ranges.size(), " of ", format_double(model.ranges.front().range_m),
                        " to ", format_double(model.ranges.back().range_m), " m")};
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

PointGrid grid_of(const std::vector<TrainedSite>& sites) {
  std::vector<Eigen::Vector3d> places_m;
  for (const TrainedSite& site : sites) places_m.push_back(site.p_world_m);
  return PointGrid(places_m);
}

// The case of this place with these features (the lowest index), if there is one.
std::optional<std::size_t> own_case(const ErrorModel& model, const PointGrid& places,
                                    const Eigen::Vector3d& p_world_m, std::uint64_t digest) {
  std::optional<std::size_t> found;
  places.visit_within(p_world_m, kSamePlace_m, [&](const NearPoint& point) {
    if (model.sites[point.index].factor_digest != digest) return;
    found = std::min(found.value_or(point.index), point.index);
  });
  return found;
}

// [place of the model]: whether one of these recordings is behind it.
std::vector<bool> places_of(const ErrorModel& model, const RecordingCards& recordings) {
  std::vector<bool> is_of;
  for (const PlaceCard& place : model.card.places) {
    is_of.push_back(std::ranges::any_of(place.recordings.cards, [&](const RecordingCard& card) {
      return have_common_scans(card, recordings);
    }));
  }
  return is_of;
}

// Recordings without coordinates of their own all begin at 0, and lie near each other for nothing.
bool is_of_the_world(const Eigen::Vector3d& p_world_m) {
  constexpr double kFarthestOwn_m = 1e5;
  return p_world_m.head<2>().cwiseAbs().maxCoeff() > kFarthestOwn_m;
}

// What the model uses of earlier drives.
HistoryKind kind_for(const ErrorModel& model) {
  std::vector<std::string> names;
  for (const FeatureCard& feature : model.features) names.push_back(feature.name);
  return history_kind_of(names);
}

// The rows that the model's forest expects. `earlier`: null where no earlier drive is known.
Result<FeatureRows> features_for(const ErrorModel& model, const FactorTable& factors,
                                 const History* earlier) {
  Result<FeatureRows> rows = gather_features(factors, factors_of(model));
  if (!rows || !model.card.knows_history) return rows;
  return with_history(*rows, kind_for(model), earlier);
}

// What a model says, stretch by stretch.
class Forest {
 public:
  Forest(const ErrorModel& model, double support_margin, int threads)
      : model_(model),
        forest_(model.forest, model.out_of_fold.limits_m, threads),
        support_(model, support_margin) {}

  // Of no site yet.
  [[nodiscard]] PredictedError nothing(double support_margin) const {
    PredictedError predicted;
    predicted.looks = model_.out_of_fold.looks;
    predicted.limits_m = model_.out_of_fold.limits_m;
    predicted.support_margin = support_margin;
    return predicted;
  }

  // Of the next sites, by the whole forest.
  void append(const PassContext& ctx, const FeatureRows& features,
              PredictedError& predicted) const {
    std::vector<std::uint32_t> rows(features.row_count);
    std::iota(rows.begin(), rows.end(), 0U);
    const ForestPrediction found = forest_.predict(features, rows, ctx.threads);
    predicted.mean_m.insert(predicted.mean_m.end(), found.mean.begin(), found.mean.end());
    predicted.within_probability.insert(predicted.within_probability.end(), found.within.begin(),
                                        found.within.end());
    const std::size_t site_count = model_.shape().site_of(features.row_count);
    predicted.site_count += static_cast<std::uint32_t>(site_count);
    predicted.out_of_fold.resize(predicted.site_count, 0);
    predicted.has_history.resize(predicted.site_count, 0);
    for (std::size_t row = 0; row < features.row_count; ++row) {
      const bool is_outside = support_.is_outside(features.row(row), model_.shape().row_of(row));
      predicted.extrapolated.push_back(is_outside ? 1 : 0);
    }
  }

 private:
  const ErrorModel& model_;
  PreparedForest forest_;
  Support support_;
};

void take_out_of_fold(const ErrorModel& model, std::size_t trained, std::size_t site,
                      PredictedError& predicted) {
  const auto copy = [&](const auto& from, auto& to, const SiteShape& shape) {
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(shape.size(trained)), shape.size(1),
                to.begin() + static_cast<std::ptrdiff_t>(shape.size(site)));
  };
  copy(model.out_of_fold.mean_m, predicted.mean_m, predicted.mean_shape());
  copy(model.out_of_fold.within_probability, predicted.within_probability,
       predicted.probability_shape());
  copy(model.out_of_fold.extrapolated, predicted.extrapolated, predicted.mean_shape());
  predicted.out_of_fold[site] = 1;
}

// Of some sites in a row.
History some_of(const History& earlier, std::size_t first, std::size_t count) {
  const std::size_t per_site =
      earlier.is_known.empty() ? 0 : earlier.values.size() / earlier.is_known.size();
  const auto known = earlier.is_known.begin() + static_cast<std::ptrdiff_t>(first);
  const auto values = earlier.values.begin() + static_cast<std::ptrdiff_t>(first * per_site);
  return {earlier.kind,
          {known, known + static_cast<std::ptrdiff_t>(count)},
          {values, values + static_cast<std::ptrdiff_t>(count * per_site)}};
}

Error from_site(Error error, std::size_t first) {
  if (first > 0) error.place = concat("from site ", first, " on, ", error.place);
  return error;
}

struct ByForest {
  PredictedError predicted;            // of every site by the whole forest
  std::vector<std::uint64_t> digests;  // [site]: of its features
};

// `earlier` is null, or of these sites.
Result<ByForest> predict_by_forest(const PassContext& ctx, const PredictErrorOptions& options,
                                   const ErrorModel& model, const PredictedSites& asked,
                                   const History* earlier) {
  const std::size_t site_count = asked.sites.sites.size();
  const Forest forest(model, options.support_margin, ctx.threads);
  ByForest all{forest.nothing(options.support_margin), {}};
  for (std::size_t first = 0; first == 0 || first < site_count; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, site_count - first);
    SIGHTLINE_ASSIGN(const FactorTable factors, asked.factors.rows(first, count));
    const History earlier_here = earlier == nullptr ? History() : some_of(*earlier, first, count);
    const Result<FeatureRows> features =
        features_for(model, factors, earlier == nullptr ? nullptr : &earlier_here);
    if (!features) return from_site(features.error(), first);
    forest.append(ctx, *features, all.predicted);
    for (std::size_t i = 0; i < count; ++i) {
      all.digests.push_back(features_digest(*features, i, model.ranges.size()));
    }
  }
  put_on_curve(model.card.curve, all.predicted);
  if (earlier != nullptr) all.predicted.has_history = earlier->is_known;
  return all;
}

// [site]: the case of the model that it is, if it is one.
using OwnCases = std::vector<std::optional<std::size_t>>;

OwnCases own_cases(const ErrorModel& model, const PredictedSites& asked,
                   const std::vector<std::uint64_t>& digests) {
  const PointGrid places = grid_of(model.sites);
  OwnCases own;
  for (std::size_t site = 0; site < digests.size(); ++site) {
    own.push_back(own_case(model, places, asked.place_of(site), digests[site]));
  }
  return own;
}

// Where both know the site as their own. What is seen at 100 m may have changed where nothing has
// within the ranges: such a site is another one to both.
void keep_common(OwnCases& ranges, OwnCases& looks) {
  for (std::size_t site = 0; site < ranges.size(); ++site) {
    if (!ranges[site]) looks[site].reset();
    if (!looks[site]) ranges[site].reset();
  }
}

// What trees said of the model's own sites that never saw their place.
void take_own_cases(const ErrorModel& model, const OwnCases& own, PredictedError& predicted) {
  for (std::size_t site = 0; site < own.size(); ++site) {
    if (own[site]) take_out_of_fold(model, *own[site], site, predicted);
  }
}

// Of sites near those that the model was trained on, which are none of them.
void warn_of_flattered(const PassContext& ctx, const ErrorModel& model, const PredictedSites& asked,
                       const OwnCases& own) {
  const PointGrid places = grid_of(model.sites);
  const std::vector<bool> is_of_place = places_of(model, asked.recordings);
  std::size_t flattered_count = 0;
  for (std::size_t site = 0; site < own.size(); ++site) {
    if (own[site]) continue;
    const Eigen::Vector3d p_world_m = asked.place_of(site);
    const auto is_known = [&](const NearPoint& point) {
      return is_of_place[model.sites[point.index].place] || is_of_the_world(p_world_m);
    };
    if (places.nearest(p_world_m, model.card.buffer_m, is_known)) ++flattered_count;
  }
  if (flattered_count == 0) return;
  ctx.warn(concat(flattered_count, " of ", own.size(), " sites are within ",
                  format_double(model.card.buffer_m),
                  " m of the model's training sites, but differ from them: if this is the same "
                  "place, predictions there may be optimistic"));
}

// `history`: none, or measured at these sites and looks.
Result<ByForest> predict_with_history(const PassContext& ctx, const PredictErrorOptions& options,
                                      const ErrorModel& model, const PredictedSites& asked,
                                      const EarlierDrives& history) {
  SIGHTLINE_TRY(check_inputs(model, asked.sites, asked.factors.head()));
  if (history.empty()) return predict_by_forest(ctx, options, model, asked, nullptr);
  const History earlier = history_of(asked.sites, history, kind_for(model));
  return predict_by_forest(ctx, options, model, asked, &earlier);
}

// Of the ranges, and of the looks that take a sample where model and map know them.
Result<ByFamily<PredictedError>> predict_both(const PassContext& ctx,
                                              const PredictErrorOptions& options,
                                              const ByFamily<ErrorModel>& model,
                                              const ByFamily<PredictedSites>& asked,
                                              const ByFamily<EarlierDrives>& history) {
  SIGHTLINE_ASSIGN(ByForest ranges,
                   predict_with_history(ctx, options, model.ranges, asked.ranges, history.ranges));
  OwnCases own = own_cases(model.ranges, asked.ranges, ranges.digests);
  std::optional<PredictedError> samples;
  if (model.samples && asked.samples) {
    SIGHTLINE_ASSIGN(ByForest looks,
                     predict_with_history(ctx, options, *model.samples, *asked.samples,
                                          history.samples.value_or(EarlierDrives())));
    OwnCases own_of_samples = own_cases(*model.samples, *asked.samples, looks.digests);
    keep_common(own, own_of_samples);
    take_own_cases(*model.samples, own_of_samples, looks.predicted);
    samples = std::move(looks.predicted);
  }
  take_own_cases(model.ranges, own, ranges.predicted);
  warn_of_flattered(ctx, model.ranges, asked.ranges, own);
  return ByFamily<PredictedError>(std::move(ranges.predicted), std::move(samples));
}

// Where the model knows history, and these drives are of its localizer. `drives` is not empty.
Result<ByFamily<PredictedError>> predict_told(const PassContext& ctx,
                                              const PredictErrorOptions& options,
                                              const ByFamily<ErrorModel>& model,
                                              const ByFamily<PredictedSites>& asked,
                                              const ByFamily<EarlierDrives>& history) {
  const EarlierDrives& drives = history.ranges;
  const TrainingCard& card = model.ranges.card;
  std::string names;
  for (const MeasuredError* drive : drives) {
    names += concat((names.empty() ? "'" : ", '"), drive->drive, "'");
  }
  const bool are_several = drives.size() > 1;
  const std::string who = (are_several ? "drives " : "drive ") + names;
  const LocalizerProfile& localizer = drives.front()->matching.localizer;
  if (!(localizer == card.localizer)) {
    ctx.warn(concat(who, (are_several ? " were" : " was"), " localized by ", to_text(localizer),
                    ", the model predicts the errors of ", to_text(card.localizer),
                    ": the errors measured here are not used"));
    return predict_both(ctx, options, model, asked, {});
  }
  if (!card.knows_history) {
    ctx.warn(concat("the model was trained on places with one drive each, so the errors of ", who,
                    " are not used"));
    return predict_both(ctx, options, model, asked, {});
  }
  ctx.inform(concat("the errors of ", who, " are model inputs: figures evaluated on ",
                    (are_several ? "those drives" : "that drive"), " are optimistic"));
  return predict_both(ctx, options, model, asked, history);
}

Result<void> check_history(const PredictedSites& asked, const MeasuredError& history) {
  if (history.scan_of_site.size() == asked.sites.sites.size() &&
      history.looks == asked.factors.head().looks) {
    return {};
  }
  return Error{ErrorCode::kMismatchedInputs,
               "the earlier drive was measured at other sites or ranges"};
}

ByFamily<EarlierDrives> earlier_drives(const ByFamily<MeasuredError>* one,
                                       const MeasuredDrives* several) {
  std::vector<ByFamily<const MeasuredError*>> drives;
  const auto add = [&](const ByFamily<MeasuredError>& drive) {
    drives.emplace_back(&drive.ranges);
    if (drive.samples) drives.back().samples = &*drive.samples;
  };
  if (one != nullptr) add(*one);
  if (several != nullptr) std::ranges::for_each(several->drives, add);
  return join_families(std::move(drives));
}

}  // namespace

std::vector<OptionField> option_fields(PredictErrorOptions& options) {
  return {number("support_margin", options.support_margin,
                 "margin outside the range of the training data within which a factor is accepted, "
                 "as a share of that range",
                 0.0, 10.0),
          choice("history", options.history,
                 "whether a given model (--model) uses the errors that the localization drives "
                 "measured here",
                 {"auto", "never"})};
}

Result<ByFamily<PredictedError>> predict_error(PassContext& ctx, const PredictErrorOptions& options,
                                               const ByFamily<ErrorModel>& model,
                                               const Sites& sites,
                                               const ByFamily<StoredTable<FactorTable>>& factors,
                                               const RecordingCards& recordings,
                                               const ByFamily<MeasuredError>* history,
                                               const MeasuredDrives* drives) {
  ByFamily<PredictedSites> asked(PredictedSites{sites, factors.ranges, recordings});
  if (factors.samples) asked.samples.emplace(PredictedSites{sites, *factors.samples, recordings});
  const ByFamily<EarlierDrives> earlier = earlier_drives(history, drives);
  for (const MeasuredError* drive : earlier.ranges) {
    SIGHTLINE_TRY(check_history(asked.ranges, *drive));
  }
  if (earlier.ranges.empty()) return predict_both(ctx, options, model, asked, {});
  return predict_told(ctx, options, model, asked, earlier);
}

Result<PredictedError> predict_looks(const PassContext& ctx, double support_margin,
                                     const ErrorModel& model, const PredictedSites& sites,
                                     const EarlierDrives& history) {
  for (const MeasuredError* drive : history) SIGHTLINE_TRY(check_history(sites, *drive));
  PredictErrorOptions options;
  options.support_margin = support_margin;
  SIGHTLINE_ASSIGN(ByForest found, predict_with_history(ctx, options, model, sites, history));
  take_own_cases(model, own_cases(model, sites, found.digests), found.predicted);
  return std::move(found.predicted);
}

}  // namespace sightline
