#include "passes/model/choice/floor.h"

#include <algorithm>

#include "formats/base/parallel.h"

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

bool says_nothing(const FloorOptions& options) {
  return options.is_too_short || options.explained <= 0.0;
}

Reason why_static(const FloorOptions& options) {
  if (options.is_simulated) return Reason::kNoDrive;
  if (options.is_too_short) return Reason::kTooShort;
  return options.explained <= 0.0 ? Reason::kExplainsNothing : Reason::kCheaper;
}

bool is_proven(double block_count, double alpha, double coverage) {
  return 1.0 - coverage + coverage / (block_count + 1.0) <= alpha;
}

void take_static(const OwnEvidence& evidence, double limit_m, std::uint8_t range_index,
                 Reason reason, std::size_t site, Choice& choice) {
  choice.range_index[site] = range_index;
  choice.reasons[site] = reason;
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

std::optional<StaticAnswers> apply_floor(const OwnEvidence& evidence, double limit_m,
                                         const FloorOptions& options, Choice& choice) {
  const Reason reason = why_static(options);
  const std::optional<StaticAnswer> answer =
      says_nothing(options) ? best_static(evidence, limit_m, options.static_coverage)
                            : cheaper_static(evidence, limit_m, options, choice);
  if (!answer) return std::nullopt;
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    take_static(evidence, limit_m, answer->range_index, reason, site, choice);
  }
  const Look& look = evidence.looks[answer->range_index];
  return StaticAnswers{reason, options.explained,        evidence.is_simulated, look,
                       look,   answer->standing.coverage};
}

StaticAnswers take_simulated(const OwnEvidence& evidence, double limit_m, double static_coverage,
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
    take_static(evidence, limit_m, choice.range_index[site], Reason::kSimulation, site, choice);
  }
  return {Reason::kSimulation,     0.0,
          evidence.is_simulated,   evidence.looks[cheapest],
          evidence.looks[dearest], standing_of(evidence, limit_m, choice.range_index).coverage};
}

void refused_take_static(const OwnEvidence& evidence, double limit_m, double static_coverage,
                         Choice& choice) {
  const StaticAnswer answer = best_static(evidence, limit_m, static_coverage);
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    if ((choice.flags[site] & kExtrapolated) == 0) continue;
    take_static(evidence, limit_m, answer.range_index, Reason::kExtrapolated, site, choice);
  }
}

}  // namespace sightline
