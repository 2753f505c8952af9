#include "passes/model/choose_ranges.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "passes/model/choice/choices.h"
#include "passes/model/forest/measured_columns.h"

namespace sightline {
namespace {

// A range is stored as one byte, in the table and in the map.
constexpr std::size_t kMostRanges = 255;

Result<void> check_inputs(const Sites& sites, const PredictedError& predicted,
                          const ErrorModel& model, const FactorTable& factors) {
  // Factors may be without values here.
  if (predicted.site_count != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs, concat("found predictions of ", predicted.site_count,
                                                      " sites, expected ", sites.sites.size())};
  }
  if (predicted.looks != model.out_of_fold.looks ||
      predicted.limits_m != model.out_of_fold.limits_m) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions and model are of different ranges or limits"};
  }
  if (factors.site_count != predicted.site_count || factors.looks != predicted.looks) {
    return Error{ErrorCode::kMismatchedInputs,
                 "factors and predictions are of different sites or ranges"};
  }
  const bool has_history = std::ranges::count(predicted.has_history, std::uint8_t{1}) > 0;
  if (has_history && !model.card.knows_history) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions use measured history, but the model has no such inputs"};
  }
  if (predicted.looks.size() > kMostRanges) {
    return Error{ErrorCode::kMismatchedInputs, concat("found ", predicted.looks.size(),
                                                      " ranges, expected at most ", kMostRanges)};
  }
  return {};
}

// Whose errors the map's own scans tell: LocalizerKind's, PCL's apart.
bool is_of_this_program(const LocalizerProfile& localizer) {
  constexpr std::string_view kOurs[] = {"plain", "annealed", "searching"};
  return std::ranges::find(kOurs, localizer.name) != std::end(kOurs);
}

RangeTable to_table(const PredictedError& predicted, Chosen chosen) {
  RangeTable table;
  table.looks = predicted.looks;
  table.site_count = predicted.site_count;
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    for (const Choice& choice : chosen.choices) {
      table.range_index.push_back(choice.range_index[site]);
      table.flags.push_back(choice.flags[site]);
      table.reasons.push_back(choice.reasons[site]);
    }
  }
  table.promises = std::move(chosen.promises);
  return table;
}

void warn_of_flags(const PassContext& ctx, const RangeTable& table) {
  for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
    std::size_t unmet_count = 0;
    for (std::size_t site = 0; site < table.site_count; ++site) {
      unmet_count += (table.flags_of(site, limit) & kUnmet) != 0 ? 1 : 0;
    }
    if (unmet_count == 0) continue;
    const char* what = takes_every_return(table.looks.front()) ? "range" : "look";
    ctx.warn(concat("no ", what, " keeps the error within ",
                    format_double(table.promises[limit].limit_m), " m at ", unmet_count, " of ",
                    table.site_count, " sites: they take the most probable ", what,
                    " and are flagged 'unmet'"));
  }
}

}  // namespace

std::vector<OptionField> option_fields(ChooseRangesOptions& options) {
  return {
      choice(
          "selection", options.selection,
          "rule: by the probability that the error is within the limit, with a promise; or by the "
          "predicted mean error, as in the paper",
          {"mean", "probability"}),
      choice("risk_control", options.risk_control, "method that sets the required probability",
             risk_control_names()),
      number("alpha", options.alpha, "allowed share of misses among the answered sites", 0.001,
             0.5),
      number("delta", options.delta, "learn-then-test: probability that the promise itself fails",
             0.0001, 0.5),
      number("probability_threshold", options.probability_threshold,
             "required probability where risk_control is fixed", 0.0, 1.0),
      number("dilation_m", options.dilation_m,
             "a site takes the longest range of its neighbours within this distance, m", 0.0,
             100.0),
      flag("extrapolated_takes_static", options.extrapolated_takes_static,
           "where factors are outside the training data, take the range that the map's own scans "
           "need")};
}

std::vector<std::string> promises_of(const ChooseRangesOptions& options, const ErrorModel& model) {
  std::vector<std::string> statements;
  if (options.selection == Selection::kMean) return statements;
  Calibrator calibrator(model, options);
  for (std::size_t limit = 0; limit < model.out_of_fold.limits_m.size(); ++limit) {
    statements.push_back("places without: " + calibrator.next(CaseKind::kMapOnly, limit).statement);
    if (!model.card.knows_history) continue;
    statements.push_back("places with measured drives: " +
                         calibrator.next(CaseKind::kHistory, limit).statement);
  }
  return statements;
}

namespace {

// The errors that the model's own drive measured at these sites.
LookErrors labels_at(const Sites& sites, const PredictedError& predicted, const ErrorModel& model,
                     OwnEvidence evidence) {
  std::ranges::fill(evidence.error_m, -1.0);
  add_measured(sites, predicted, model, evidence);
  LookErrors labels{std::move(evidence.error_m), {}};
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    const bool is_measured = labels.error_m[evidence.shape().index(site, 0)] >= 0.0;
    labels.is_measured.push_back(is_measured ? 1 : 0);
  }
  return labels;
}

LookErrors errors_of(const MeasuredError& drive) {
  LookErrors errors;
  for (const ErrorRow& row : drive.rows) errors.error_m.push_back(row.mean_m);
  for (const std::int64_t scan : drive.scan_of_site) errors.is_measured.push_back(scan >= 0);
  return errors;
}

// Of looks that take a sample. `own`: of the map's own scans alone. Error: cannot-read.
Result<LookEvidence> look_evidence(const Sites& sites, const PredictedError& predicted,
                                   const ErrorModel& model, const StoredTable<FactorTable>& factors,
                                   const std::vector<PlaceKind>& kinds, const OwnEvidence& own) {
  LookEvidence evidence{own.shape(), {}, kinds, route_of(sites), {own.error_m, {}}, {}};
  evidence.own.is_measured.assign(own.site_count, 1);
  evidence.is_simulated = own.is_simulated;
  for (std::size_t look = 0; look < own.looks.size(); ++look) {
    const std::vector<std::uint8_t> everywhere(own.site_count, static_cast<std::uint8_t>(look));
    evidence.cost.push_back(standing_of(own, 0.0, everywhere).cost);
  }
  evidence.drives.push_back(labels_at(sites, predicted, model, own));
  if (!has_measured_columns(factors.head())) return evidence;
  SIGHTLINE_ASSIGN(const FactorTable whole, factors.whole());
  for (const ByFamily<MeasuredError>& drive : measured_of_columns(whole)) {
    evidence.drives.push_back(errors_of(drive.ranges));
  }
  return evidence;
}

// What the choices of both families are made of.
struct ChoiceCase {
  const ChooseRangesOptions& options;
  const Sites& sites;
  const std::vector<PlaceKind>& kinds;
  const std::vector<LeftOutDrive>& left_out;
};

// By the looks of one family.
Result<RangeTable> choose_own(PassContext& ctx, const ChoiceCase& of,
                              const PredictedError& predicted, const ErrorModel& model,
                              const StoredTable<FactorTable>& factors,
                              const MeasuredError* measured) {
  const auto& [options, sites, kinds, left_out] = of;
  SIGHTLINE_TRY(check_inputs(sites, predicted, model, factors.head()));
  SIGHTLINE_ASSIGN(OwnEvidence evidence, own_evidence_of(factors));
  std::optional<LookEvidence> looks;
  if (!takes_every_return(predicted.looks.front())) {
    SIGHTLINE_ASSIGN(looks, look_evidence(sites, predicted, model, factors, kinds, evidence));
  }
  if (!is_of_this_program(model.card.localizer)) {
    evidence = for_another_localizer(std::move(evidence));
  }
  add_measured(sites, predicted, model, evidence);
  const bool is_mean = options.selection == Selection::kMean;
  const LookEvidence* const of_looks = looks ? &*looks : nullptr;
  const ChoiceInputs inputs{sites, predicted, model, evidence, left_out, of_looks, measured};
  RangeTable table = to_table(predicted, choose_all(options, inputs));
  table.selection = options.selection;
  table.dilation_m = is_mean || looks ? 0.0 : options.dilation_m;
  table.extrapolated_takes_static = options.extrapolated_takes_static;
  warn_of_flags(ctx, table);
  return table;
}

// Null where none was measured.
const MeasuredError* measured_of(const ByFamily<MeasuredError>* measured, bool takes_sample) {
  if (measured == nullptr) return nullptr;
  if (!takes_sample) return &measured->ranges;
  return measured->samples ? &*measured->samples : nullptr;
}

}  // namespace

Result<ByFamily<RangeTable>> choose_ranges(PassContext& ctx, const ChooseRangesOptions& options,
                                           const Sites& sites,
                                           const ByFamily<PredictedError>& predicted,
                                           const ByFamily<ErrorModel>& model,
                                           const ByFamily<StoredTable<FactorTable>>& factors,
                                           const ByFamily<MeasuredError>* measured) {
  SIGHTLINE_TRY(check_inputs(sites, predicted.ranges, model.ranges, factors.ranges.head()));
  if (predicted.samples && (!model.samples || !factors.samples)) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions contain looks that take a sample; the model or the factors do not"};
  }
  std::vector<LeftOutDrive> left_out;
  if (std::ranges::count(predicted.ranges.has_history, std::uint8_t{1}) > 0) {
    SIGHTLINE_ASSIGN(const FactorTable whole, factors.ranges.whole());
    SIGHTLINE_ASSIGN(left_out,
                     leave_out_in_turn(ctx, model, sites, whole, predicted.ranges.support_margin));
  }
  SIGHTLINE_ASSIGN(const std::vector<PlaceKind> kinds, place_kinds(sites, factors.ranges));
  const auto of_family = [&](const PredictedError& answers, const ErrorModel& by,
                             const StoredTable<FactorTable>& seen) {
    const bool takes_sample = &answers != &predicted.ranges;
    return choose_own(ctx, {options, sites, kinds, left_out}, answers, by, seen,
                      measured_of(measured, takes_sample));
  };
  return each_family(of_family, predicted, model, factors);
}

}  // namespace sightline
