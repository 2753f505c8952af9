#include "formats/annotation/predicted_error.h"

#include <cmath>
#include <string>

namespace sightline {
namespace {

Error invalid_site(std::size_t site, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("site ", site)};
}

bool is_ascending_and_positive(const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i]) || values[i] <= (i == 0 ? 0.0 : values[i - 1])) return false;
  }
  return !values.empty();
}

Result<void> validate_shape(const PredictedError& predicted) {
  SIGHTLINE_TRY(validate(predicted.looks));
  if (!is_ascending_and_positive(predicted.limits_m)) {
    return Error{ErrorCode::kInvalidArtifact, "limits are not positive and ascending"};
  }
  if (predicted.mean_m.size() != predicted.mean_shape().size(predicted.site_count) ||
      predicted.within_probability.size() !=
          predicted.probability_shape().size(predicted.site_count) ||
      predicted.extrapolated.size() != predicted.mean_m.size() ||
      predicted.out_of_fold.size() != predicted.site_count ||
      predicted.has_history.size() != predicted.site_count) {
    return Error{ErrorCode::kInvalidArtifact,
                 concat("predictions do not fill ", predicted.site_count, " sites x ",
                        predicted.looks.size(), " looks")};
  }
  return {};
}

Result<void> validate_pair(const PredictedError& predicted, std::size_t site, std::size_t range) {
  const double mean_m = predicted.mean(site, range);
  if (!std::isfinite(mean_m) || mean_m < 0.0) {
    return invalid_site(site,
                        concat("found a predicted mean error of ", format_double(mean_m), " m"));
  }
  double previous = 0.0;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    const double probability = predicted.probability(site, range, limit);
    if (!(probability >= previous && probability <= 1.0)) {
      return invalid_site(site, concat("found a probability of ", format_double(probability),
                                       ", expected ", format_double(previous), " to 1"));
    }
    previous = probability;
  }
  return {};
}

// Calls use(field) for what a model keeps.
template <class Predictions, class Use>
void visit_predictions(Predictions& predicted, const Use& use) {
  const auto visit = [&](std::string_view name, auto& field) {
    if (name != "support_margin") use(field);
  };
  fields(visit, predicted);
}

}  // namespace

Result<void> validate(const PredictedError& predicted) {
  SIGHTLINE_TRY(validate_shape(predicted));
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    if (predicted.out_of_fold[site] > 1 || predicted.has_history[site] > 1) {
      return invalid_site(site, "found a flag other than 0 and 1");
    }
    for (std::size_t range = 0; range < predicted.looks.size(); ++range) {
      if (predicted.extrapolated[predicted.mean_shape().index(site, range)] > 1) {
        return invalid_site(site, "found a flag other than 0 and 1");
      }
      SIGHTLINE_TRY(validate_pair(predicted, site, range));
    }
  }
  return {};
}

Table dump(const PredictedError& predicted) {
  Table table;
  table.name = "predicted-error";
  table.columns = {"site",        "range_m",     "look",        "extrapolated",
                   "out_of_fold", "has_history", "mean_error_m"};
  for (const double limit_m : predicted.limits_m) {
    table.columns.push_back(concat("p_within_", format_double(limit_m), "_m"));
  }
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    for (std::size_t look = 0; look < predicted.looks.size(); ++look) {
      std::vector<Cell> row = {static_cast<std::int64_t>(site),
                               predicted.looks[look].range_m,
                               to_text(predicted.looks[look]),
                               std::int64_t{predicted.is_extrapolated(site, look) ? 1 : 0},
                               std::int64_t{predicted.out_of_fold[site]},
                               std::int64_t{predicted.has_history[site]},
                               predicted.mean(site, look)};
      for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
        row.emplace_back(predicted.probability(site, look, limit));
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

void encode_predictions(const PredictedError& predicted, ByteWriter& writer) {
  visit_predictions(predicted, [&](const auto& field) { FieldWriter(writer).put(field); });
}

void decode_predictions(ByteReader& reader, PredictedError& predicted) {
  visit_predictions(predicted, [&](auto& field) { FieldReader(reader).get(field); });
}

}  // namespace sightline
