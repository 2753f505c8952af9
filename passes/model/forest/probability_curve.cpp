#include "passes/model/forest/probability_curve.h"

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr double kSaturated = 0.005;
constexpr double kPriorPairs = 20.0;
constexpr int kMostSteps = 50;
constexpr double kStepIsSmall = 1e-10;
constexpr double kLongestStep = 0.5;  // where the likelihood is flat Newton leaps out of sight

double log_odds(double share) { return portable_log(share / (1.0 - share)); }

double from_log_odds(double odds) { return 1.0 / (1.0 + portable_exp(-odds)); }

// Terms of the likelihood's gradient and Hessian, summed over the pairs.
struct NewtonSums {
  double gradient_offset = 0.0;
  double gradient_slope = 0.0;
  double offset_offset = 0.0;
  double offset_slope = 0.0;
  double slope_slope = 0.0;
};

NewtonSums sums_at(const ProbabilityCurve& curve, const std::vector<double>& odds,
                   const std::vector<double>& met) {
  const std::size_t count = odds.size();
  std::vector<double> residual(count), weight(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double p = from_log_odds(curve.offset + curve.slope * odds[i]);
    residual[i] = met[i] - p;
    weight[i] = p * (1.0 - p);
  }
  const auto sum = [&](const auto& term) {
    std::vector<double> terms(count);
    for (std::size_t i = 0; i < count; ++i) terms[i] = term(i);
    return ordered_sum(terms);
  };
  NewtonSums sums;
  sums.gradient_offset = ordered_sum(residual) - kPriorPairs * curve.offset;
  sums.gradient_slope =
      sum([&](std::size_t i) { return residual[i] * odds[i]; }) - kPriorPairs * (curve.slope - 1.0);
  sums.offset_offset = ordered_sum(weight) + kPriorPairs;
  sums.offset_slope = sum([&](std::size_t i) { return weight[i] * odds[i]; });
  sums.slope_slope =
      sum([&](std::size_t i) { return weight[i] * odds[i] * odds[i]; }) + kPriorPairs;
  return sums;
}

}  // namespace

double on_curve(const ProbabilityCurve& curve, double share) {
  const bool is_identity = curve.offset == 0.0 && curve.slope == 1.0;
  if (share <= 0.0 || share >= 1.0 || is_identity) return share;
  return from_log_odds(curve.offset + curve.slope * log_odds(share));
}

ProbabilityCurve fit_curve(const PredictedShares& shares) {
  std::vector<double> odds, met;
  for (std::size_t i = 0; i < shares.share.size(); ++i) {
    if (shares.share[i] < kSaturated || shares.share[i] > 1.0 - kSaturated) continue;
    odds.push_back(log_odds(shares.share[i]));
    met.push_back(shares.is_met[i]);
  }
  ProbabilityCurve curve;
  bool has_converged = false;
  for (int step = 0; step < kMostSteps && !has_converged; ++step) {
    const NewtonSums sums = sums_at(curve, odds, met);
    // Above 0: the prior alone makes it so.
    const double determinant =
        sums.offset_offset * sums.slope_slope - sums.offset_slope * sums.offset_slope;
    const double offset_step =
        (sums.slope_slope * sums.gradient_offset - sums.offset_slope * sums.gradient_slope) /
        determinant;
    const double slope_step =
        (sums.offset_offset * sums.gradient_slope - sums.offset_slope * sums.gradient_offset) /
        determinant;
    curve.offset += std::clamp(offset_step, -kLongestStep, kLongestStep);
    curve.slope += std::clamp(slope_step, -kLongestStep, kLongestStep);
    has_converged = std::abs(offset_step) + std::abs(slope_step) < kStepIsSmall;
  }
  return has_converged && curve.slope > 0.0 ? curve : ProbabilityCurve{};
}

PredictedShares predicted_shares(const TrainingSet& training_set, const PredictedError& predicted) {
  PredictedShares shares;
  for (std::size_t site = 0; site < training_set.sites.size(); ++site) {
    if (training_set.sites[site].has_label == 0) continue;
    for (std::size_t range = 0; range < training_set.range_count; ++range) {
      const double error_m = training_set.labels[training_set.shape().index(site, range)];
      for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
        shares.share.push_back(predicted.probability(site, range, limit));
        shares.is_met.push_back(error_m <= predicted.limits_m[limit] ? 1 : 0);
      }
    }
  }
  return shares;
}

void put_on_curve(const ProbabilityCurve& curve, PredictedError& predicted) {
  for (double& probability : predicted.within_probability) {
    probability = on_curve(curve, probability);
  }
}

}  // namespace sightline
