#include "passes/emit/prove_annotation.h"

#include <algorithm>
#include <bit>

#include "formats/record/codec.h"
#include "passes/model/choose_ranges.h"
#include "passes/model/forest/measured_columns.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/promise/promise_text.h"

namespace sightline {
namespace {

Error unfounded(const std::string& place, const std::string& message) {
  return {ErrorCode::kDigestMismatch, message, "", place};
}

std::string at_site(std::size_t site) { return concat("site ", site); }

// Bit for bit: what is stored is exact.
bool is_same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

Result<ByFamily<PredictedError>> predicted_again(PassContext& ctx, const CompiledMap& map,
                                                 const ByFamily<ErrorModel>& model,
                                                 const ByFamily<FactorTable>& factors) {
  PredictErrorOptions options;
  options.support_margin = map.predicted.support_margin;
  MeasuredDrives history{measured_of_columns(factors), {}, 0};
  // Nothing else was used.
  for (ByFamily<MeasuredError>& drive : history.drives) {
    drive.ranges.matching.localizer = model.ranges.card.localizer;
  }
  // Which recordings made the map matters to a warning alone.
  return predict_error(ctx, options, model, map.sites, factors, {}, nullptr, &history);
}

Result<void> compare_numbers(const PredictedError& stored, const PredictedError& again) {
  const SiteShape means = stored.mean_shape();
  const SiteShape shares = stored.probability_shape();
  for (std::size_t row = 0; row < stored.mean_m.size(); ++row) {
    const std::string range = " at " + to_text(stored.looks[means.row_of(row)]);
    if (!is_same(stored.mean_m[row], again.mean_m[row])) {
      return unfounded(
          at_site(means.site_of(row)),
          concat("found a predicted error of ", format_double(stored.mean_m[row]), " m", range,
                 ", its factors and the forest give ", format_double(again.mean_m[row]), " m"));
    }
    for (std::size_t i = row * shares.columns; i < (row + 1) * shares.columns; ++i) {
      if (is_same(stored.within_probability[i], again.within_probability[i])) continue;
      return unfounded(
          at_site(shares.site_of(i)),
          concat("found P(error <= ", format_double(stored.limits_m[shares.column_of(i)]),
                 " m) = ", format_double(stored.within_probability[i]), range,
                 ", its factors and the forest give ", format_double(again.within_probability[i])));
    }
  }
  return {};
}

Result<void> compare_flags(const PredictedError& stored, const PredictedError& again) {
  for (std::size_t site = 0; site < stored.site_count; ++site) {
    bool is_same_support = true;
    for (std::size_t range = 0; range < stored.looks.size(); ++range) {
      is_same_support &= stored.is_extrapolated(site, range) == again.is_extrapolated(site, range);
    }
    if (!is_same_support || stored.out_of_fold[site] != again.out_of_fold[site] ||
        stored.has_history[site] != again.has_history[site]) {
      return unfounded(at_site(site),
                       "the flags of its prediction differ from those that its factors, the "
                       "model's support and the model's sites give");
    }
  }
  return {};
}

Result<void> compare_predictions(const PredictedError& stored, const PredictedError& again) {
  const Result<void> follows = compare_numbers(stored, again);
  return follows ? compare_flags(stored, again) : follows;
}

ChooseRangesOptions choice_options(const CompiledMap& map) {
  const LimitPromise& promise = map.ranges.promises.front();
  ChooseRangesOptions options;
  options.selection = map.ranges.selection;
  options.dilation_m = map.ranges.dilation_m;
  // Under the mean rule nothing is controlled, and the method is called "mean".
  const auto control = std::ranges::find(risk_control_names(), promise.method);
  if (control != risk_control_names().end()) {
    options.risk_control = static_cast<RiskControl>(control - risk_control_names().begin());
  }
  if (promise.alpha > 0.0) options.alpha = promise.alpha;
  options.delta = promise.delta;
  options.probability_threshold = promise.probability_threshold;  // of "fixed"
  options.extrapolated_takes_static = map.ranges.extrapolated_takes_static;
  return options;
}

bool is_same(const LimitPromise& a, const LimitPromise& b) {
  ByteWriter of_a, of_b;
  FieldWriter(of_a).put(a);
  FieldWriter(of_b).put(b);
  return std::ranges::equal(of_a.bytes(), of_b.bytes());
}

// A promise that measured errors contradict was withdrawn; these cannot be made again.
bool is_withdrawn(const LimitPromise& stored, LimitPromise again) {
  if (stored.is_earned || !again.is_earned || !is_contradicted(stored)) return false;
  again.is_earned = false;
  again.statement = stored.statement;
  return is_same(stored, again);
}

Result<void> compare_choices(const RangeTable& stored, const RangeTable& again) {
  for (std::size_t limit = 0; limit < stored.promises.size(); ++limit) {
    if (is_same(stored.promises[limit], again.promises[limit])) continue;
    if (is_withdrawn(stored.promises[limit], again.promises[limit])) continue;
    return unfounded(concat("limit ", format_double(stored.promises[limit].limit_m), " m"),
                     concat("found the promise \"", stored.promises[limit].statement,
                            "\", the model gives \"", again.promises[limit].statement, "\""));
  }
  const SiteShape shape = stored.shape();
  for (std::size_t i = 0; i < stored.range_index.size(); ++i) {
    if (stored.range_index[i] == again.range_index[i] && stored.flags[i] == again.flags[i] &&
        stored.reasons[i] == again.reasons[i]) {
      continue;
    }
    return unfounded(
        at_site(shape.site_of(i)),
        concat("found ", to_text(stored.looks[stored.range_index[i]]), ", flags ", stored.flags[i],
               ", for a limit of ", format_double(stored.promises[shape.row_of(i)].limit_m),
               " m, its predictions give ", to_text(again.looks[again.range_index[i]]), ", flags ",
               again.flags[i]));
  }
  return {};
}

// Of ranges and looks. Error: mismatched-inputs, or what differs.
Result<void> compare_with(PassContext& ctx, const CompiledMap& map,
                          const ByFamily<ErrorModel>& model, const ChooseRangesOptions& options) {
  SIGHTLINE_ASSIGN(
      const ByFamily<RangeTable> again,
      choose_ranges(ctx, options, map.sites, predicted_of(map), model, factors_of(map)));
  SIGHTLINE_TRY(compare_choices(map.ranges, again.ranges));
  return map.looks ? compare_choices(map.looks->ranges, *again.samples) : Result<void>();
}

// What was measured cannot be made again, and is not compared.
Result<void> compare_quality(const std::vector<LimitQuality>& of_map,
                             const std::vector<LimitQuality>& again, const CompiledMap& map) {
  for (std::size_t limit = 0; limit < again.size(); ++limit) {
    const LimitQuality& stored = of_map[limit];
    if (stored.unmet_count == again[limit].unmet_count &&
        stored.extrapolated_count == again[limit].extrapolated_count &&
        is_same(stored.mean_range_m, again[limit].mean_range_m) &&
        is_same(stored.expected_coverage, again[limit].expected_coverage)) {
      continue;
    }
    return unfounded(concat("limit ", format_double(map.ranges.promises[limit].limit_m), " m"),
                     "the quality figures of the map differ from those of its sites");
  }
  return {};
}

std::uint32_t count_of(const std::vector<std::uint8_t>& flags) {
  return static_cast<std::uint32_t>(std::ranges::count(flags, std::uint8_t{1}));
}

}  // namespace

Result<AnnotationProof> prove_annotation(PassContext& ctx, const CompiledMap& map) {
  if (map.factors.factors.empty()) {
    return Error{ErrorCode::kBadLayer,
                 "the map has no factors (`sightline strip` removed them), so its annotation "
                 "cannot be checked"};
  }
  SIGHTLINE_ASSIGN(const ByFamily<ErrorModel> model, model_of(map.model));
  SIGHTLINE_ASSIGN(const ByFamily<PredictedError> predicted,
                   predicted_again(ctx, map, model, factors_of(map)));
  if (predicted.samples.has_value() != map.looks.has_value()) {
    return unfounded("looks", "the map's model or factors do not include its looks");
  }
  SIGHTLINE_TRY(compare_predictions(map.predicted, predicted.ranges));
  if (map.looks) SIGHTLINE_TRY(compare_predictions(map.looks->predicted, *predicted.samples));
  SIGHTLINE_TRY(compare_with(ctx, map, model, choice_options(map)));
  SIGHTLINE_TRY(compare_quality(map.quality, quality_of(map.predicted, map.ranges, nullptr), map));
  if (map.looks) {
    const auto& [of_looks, ranges, quality, factors] = *map.looks;
    SIGHTLINE_TRY(compare_quality(quality, quality_of(of_looks, ranges, nullptr), map));
  }
  AnnotationProof proof;
  proof.site_count = map.predicted.site_count;
  proof.out_of_fold_count = count_of(map.predicted.out_of_fold);
  proof.forest_count = proof.site_count - proof.out_of_fold_count;
  proof.history_count = count_of(map.predicted.has_history);
  return proof;
}

std::string to_text(const AnnotationProof& proof) {
  std::string text = concat(
      "annotation of ", proof.site_count,
      " sites verified: ranges, flags and promises follow from the predictions; ",
      proof.forest_count, " sites' predictions were repeated by the forest from their factors");
  if (proof.history_count > 0) {
    text += concat(" (", proof.history_count, " of them with stored errors of earlier drives)");
  }
  if (proof.out_of_fold_count > 0) {
    text += concat("; ", proof.out_of_fold_count,
                   " sites trained the model, and their predictions match those stored in it");
  }
  return text + "\n";
}

}  // namespace sightline
