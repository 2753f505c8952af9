#include "passes/model/choose_tracking_looks.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "formats/reader/site_looks.h"
#include "passes/model/choice/looks_of_kinds.h"
#include "passes/model/forest/predict_error.h"

namespace sightline {
namespace {

// Whether its errors from tracking starts are of these sites and of the model's looks and
// localizer.
bool is_evidence(const MeasuredError& measured, const Sites& sites, const ErrorModel& model) {
  return !measured.tracking_offsets.empty() && measured.reference != ErrorReference::kSimulated &&
         measured.matching.localizer == model.card.localizer &&
         measured.looks == model.out_of_fold.looks &&
         measured.scan_of_site.size() == sites.sites.size();
}

LookErrors tracking_errors(const MeasuredError& measured) {
  LookErrors errors;
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    const bool is_measured = measured.scan_of_site[site] >= 0;
    errors.is_measured.push_back(is_measured ? 1 : 0);
    for (std::size_t look = 0; look < measured.looks.size(); ++look) {
      errors.error_m.push_back(is_measured ? tracking_error_m(measured, site, look) : 0.0);
    }
  }
  return errors;
}

// Of the model's own sites.
LookEvidence evidence_of_training(const ErrorModel& model) {
  LookEvidence evidence{model.shape(), {}, {}, route_of(model.sites), {}, {}};
  evidence.own.error_m = model.measured_mean_m;
  for (const TrainedSite& site : model.sites) {
    evidence.kinds.push_back(site.kind);
    evidence.own.is_measured.push_back(site.has_label);
  }
  return evidence;
}

// `errors`: of a drive that was measured at these sites; none: the evidence is of the model's.
LookEvidence look_evidence(const Sites& sites, const ErrorModel& model,
                           const std::vector<PlaceKind>& kinds, const OwnEvidence& own,
                           const std::optional<LookErrors>& errors) {
  LookEvidence evidence = evidence_of_training(model);
  if (errors) evidence = {own.shape(), {}, kinds, route_of(sites), *errors, {}};
  for (std::size_t look = 0; look < own.looks.size(); ++look) {
    const std::vector<std::uint8_t> everywhere(own.site_count, static_cast<std::uint8_t>(look));
    evidence.cost.push_back(standing_of(own, 0.0, everywhere).cost);
  }
  return evidence;
}

// Where a drive was measured from tracking starts, its errors are the site's own evidence;
// elsewhere those of the map's own scans, from acquiring starts.
void take_measured(const LookErrors& errors, OwnEvidence& own) {
  for (std::size_t site = 0; site < own.site_count; ++site) {
    for (std::size_t look = 0; look < own.looks.size() && errors.is_measured[site] == 1; ++look) {
      const std::size_t i = own.shape().index(site, look);
      own.error_m[i] = errors.error_m[i];
    }
  }
}

// Of the looks that take a sample.
EarlierDrives earlier_drives(const ByFamily<MeasuredError>* one, const MeasuredDrives* several,
                             const TrainingCard& card) {
  EarlierDrives drives;
  const auto add = [&](const ByFamily<MeasuredError>& drive) {
    const bool is_input =
        card.knows_history && drive.samples && drive.samples->matching.localizer == card.localizer;
    if (is_input) drives.push_back(&*drive.samples);
  };
  if (one != nullptr) add(*one);
  if (several != nullptr) std::ranges::for_each(several->drives, add);
  return drives;
}

constexpr int kShareSteps = 128;

// A column without values.
SiteColumn look_column(std::size_t limit, std::size_t look_count) {
  SiteColumn column{tracking_look_column(0, limit), "", {}, {}};
  const auto count = static_cast<int>(look_count);
  for (int number = -count; number < count; ++number) {
    column.steps.push_back(static_cast<float>(number));
  }
  return column;
}

SiteColumn probability_column(std::size_t limit) {
  SiteColumn column{tracking_look_column(1, limit), "", {}, {}};
  for (int step = 0; step <= kShareSteps; ++step) {
    column.steps.push_back(static_cast<float>(step) / static_cast<float>(kShareSteps));
  }
  return column;
}

void append_limit(const PredictedError& predicted, std::size_t limit, const Choice& choice,
                  TrackingLooks& looks) {
  SiteColumn numbers = look_column(limit, predicted.looks.size());
  SiteColumn probabilities = probability_column(limit);
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    const std::size_t look = choice.range_index[site];
    const auto number = static_cast<float>(look);
    numbers.values.push_back(choice.is_answered(site) ? number : -1.0F - number);
    // Rounded down: none is promised more than is predicted.
    const double steps = std::floor(predicted.probability(site, look, limit) * kShareSteps);
    probabilities.values.push_back(static_cast<float>(steps / kShareSteps));
  }
  looks.columns.push_back(std::move(numbers));
  looks.columns.push_back(std::move(probabilities));
}

}  // namespace

std::vector<OptionField> option_fields(ChooseTrackingLooksOptions& options) {
  std::vector<OptionField> fields = option_fields(options.choice);
  fields.push_back(number("support_margin", options.support_margin,
                          "margin outside the range of the training data", 0.0, 10.0));
  for (OptionField& field : fields) field.is_shared = true;
  return fields;
}

ErrorModel tracking_model(const ErrorModel& model) {
  SIGHTLINE_CHECK(!model.tracking.is_empty());
  ErrorModel of_tracking = model;
  const TrackingLabels labels = std::exchange(of_tracking.tracking, {});
  of_tracking.card.curve = labels.curve;
  of_tracking.forest.labels.assign(labels.row_errors_m.begin(), labels.row_errors_m.end());
  of_tracking.measured_mean_m.assign(labels.measured_m.begin(), labels.measured_m.end());
  of_tracking.out_of_fold.mean_m.assign(labels.mean_m.begin(), labels.mean_m.end());
  of_tracking.out_of_fold.within_probability.assign(labels.within_probability.begin(),
                                                    labels.within_probability.end());
  return of_tracking;
}

Result<TrackingLooks> choose_tracking_looks(
    PassContext& ctx, const ChooseTrackingLooksOptions& options, const Sites& sites,
    const ByFamily<ErrorModel>& model, const ByFamily<StoredTable<FactorTable>>& factors,
    const RecordingCards& recordings, const ByFamily<MeasuredError>* measured,
    const ByFamily<MeasuredError>* history, const MeasuredDrives* drives) {
  TrackingLooks looks;
  const bool is_by_mean = options.choice.selection == Selection::kMean;
  const bool has_labels = model.samples && !model.samples->tracking.is_empty();
  if (is_by_mean || !has_labels || !factors.samples) return looks;
  const ErrorModel of_tracking = tracking_model(*model.samples);
  SIGHTLINE_ASSIGN(
      const PredictedError predicted,
      predict_looks(ctx, options.support_margin, of_tracking, {sites, *factors.samples, recordings},
                    earlier_drives(history, drives, of_tracking.card)));
  SIGHTLINE_ASSIGN(const std::vector<PlaceKind> kinds, place_kinds(sites, factors.ranges));
  SIGHTLINE_ASSIGN(OwnEvidence own, own_evidence_of(*factors.samples));
  std::optional<LookErrors> errors;
  if (measured != nullptr && measured->samples &&
      is_evidence(*measured->samples, sites, of_tracking)) {
    errors = tracking_errors(*measured->samples);
  }
  const LookEvidence evidence = look_evidence(sites, of_tracking, kinds, own, errors);
  if (errors) take_measured(*errors, own);
  const std::vector<LeftOutDrive> no_drives;
  const ChoiceInputs inputs{sites, predicted, of_tracking, own, no_drives, &evidence};
  const Chosen chosen = choose_all(options.choice, inputs);
  for (std::size_t limit = 0; limit < chosen.choices.size(); ++limit) {
    append_limit(predicted, limit, chosen.choices[limit], looks);
    looks.promises.push_back(chosen.promises[limit].statement);
  }
  return looks;
}

}  // namespace sightline
