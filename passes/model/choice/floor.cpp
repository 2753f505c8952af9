#include "passes/model/choice/floor.h"

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// The static answer that is to replace `choice`; nothing where the choice is no dearer.
std::optional<StaticAnswer> cheaper_static(const OwnEvidence& evidence, double limit_m,
                                           const FloorOptions& options, const Choice& choice) {
  const Standing own = standing_of(evidence, limit_m, choice.range_index);
  const double worth = options.is_promised ? kPromiseWorth : 1.0;
  const auto if_cheaper = [&](double least_coverage) -> std::optional<StaticAnswer> {
    const StaticAnswer answer = best_static(evidence, limit_m, least_coverage);
    const bool covers = answer.standing.coverage >= std::min(own.coverage, least_coverage);
    if (!covers || answer.standing.cost * worth >= own.cost) return std::nullopt;
    if (options.is_promised &&
        !is_proven(options.block_count, options.alpha, answer.standing.coverage)) {
      return std::nullopt;
    }
    return answer;
  };
  if (own.coverage <= 0.0) return std::nullopt;
  const std::optional<StaticAnswer> answer = if_cheaper(options.static_coverage);
  if (answer || own.coverage >= options.static_coverage) return answer;
  return if_cheaper(own.coverage);
}

std::string found_here(const OwnEvidence& evidence) {
  return evidence.is_simulated ? "what was simulated here, each error taken twice,"
                               : "what was measured here";
}

std::string reason_of(const OwnEvidence& evidence, const FloorOptions& options) {
  if (options.is_simulated) {
    return "no drive was here, and no model from elsewhere judges what was simulated";
  }
  if (options.is_too_short) return "the drive is too short to learn from";
  if (options.explained <= 0.0) {
    return "the model explains nothing out of fold (R^2 " + fixed(options.explained, 2) + ")";
  }
  return "the model's own choice costs more and covers no more of " + found_here(evidence);
}

// The least share of sites that a street's cheapest answer must be enough for, by simulation.
constexpr double kLeastSimulated = 0.8;

std::uint8_t cheapest_within(const OwnEvidence& evidence, double limit_m, std::size_t site,
                             std::uint8_t otherwise) {
  for (std::size_t look = 0; look < evidence.looks.size(); ++look) {
    const bool is_within = evidence.error_m[evidence.shape().index(site, look)] <= limit_m;
    if (is_within) return static_cast<std::uint8_t>(look);
  }
  return otherwise;
}

}  // namespace

bool is_proven(double block_count, double alpha, double coverage) {
  return 1.0 - coverage + coverage / (block_count + 1.0) <= alpha;
}

void take_static(const OwnEvidence& evidence, double limit_m, std::uint8_t range_index,
                 std::size_t site, Choice& choice) {
  choice.range_index[site] = range_index;
  choice.flags[site] &= static_cast<std::uint8_t>(~kUnmet);
  choice.flags[site] |= kStatic;
  const double error_m = evidence.error_m[evidence.shape().index(site, range_index)];
  if (error_m > limit_m) choice.flags[site] |= kUnmet;
}

double explained_share(const ErrorModel& model) {
  std::vector<double> residuals, totals;
  for (std::size_t range = 0; range < model.ranges.size(); ++range) {
    std::vector<double> labels;
    for (std::size_t i = 0; i < model.sites.size(); ++i) {
      if (model.sites[i].has_label == 0) continue;
      labels.push_back(model.measured(i, range));
      const double residual = model.out_of_fold.mean(i, range) - labels.back();
      residuals.push_back(residual * residual);
    }
    const double mean =
        labels.empty() ? 0.0 : ordered_sum(labels) / static_cast<double>(labels.size());
    for (const double label : labels) totals.push_back((label - mean) * (label - mean));
  }
  const double total = ordered_sum(totals);
  return total > 0.0 ? 1.0 - ordered_sum(residuals) / total : 0.0;
}

std::optional<std::string> apply_floor(const OwnEvidence& evidence, double limit_m,
                                       const FloorOptions& options, Choice& choice) {
  const bool says_nothing = options.is_too_short || options.explained <= 0.0;
  const std::optional<StaticAnswer> answer =
      says_nothing ? best_static(evidence, limit_m, options.static_coverage)
                   : cheaper_static(evidence, limit_m, options, choice);
  if (!answer) return std::nullopt;
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    take_static(evidence, limit_m, answer->range_index, site, choice);
  }
  return "nothing is promised: " + reason_of(evidence, options) + "; everywhere it takes " +
         to_text(evidence.looks[answer->range_index]) + ", where " + found_here(evidence) +
         " is within " + format_double(limit_m) + " m at " + percent(answer->standing.coverage) +
         " of the sites";
}

std::string take_simulated(const OwnEvidence& evidence, double limit_m, double static_coverage,
                           const DilatedRoute& dilated, Choice& choice) {
  const std::uint8_t one = best_static(evidence, limit_m, kLeastSimulated).range_index;
  const std::uint8_t other = best_static(evidence, limit_m, static_coverage).range_index;
  const std::uint8_t cheapest = std::min(one, other);
  const std::uint8_t dearest = std::max(one, other);
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    choice.range_index[site] =
        std::clamp(cheapest_within(evidence, limit_m, site, dearest), cheapest, dearest);
  }
  dilate(dilated.route, dilated.dilation_m, choice);
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    take_static(evidence, limit_m, choice.range_index[site], site, choice);
  }
  const double coverage = standing_of(evidence, limit_m, choice.range_index).coverage;
  const std::string from = to_text(evidence.looks[cheapest]);
  const std::string to = to_text(evidence.looks[dearest]);
  return "nothing is promised: " + reason_of(evidence, {.is_simulated = true}) + "; " +
         (cheapest == dearest ? "everywhere it takes " + from
                              : "it takes from " + from + " to " + to + ", by site") +
         ", where " + found_here(evidence) + " is within " + format_double(limit_m) + " m at " +
         percent(coverage) + " of the sites";
}

void refused_take_static(const OwnEvidence& evidence, double limit_m, double static_coverage,
                         Choice& choice) {
  const StaticAnswer answer = best_static(evidence, limit_m, static_coverage);
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    if ((choice.flags[site] & kExtrapolated) == 0) continue;
    take_static(evidence, limit_m, answer.range_index, site, choice);
  }
}

}  // namespace sightline
