#pragma once

#include <cstdint>
#include <vector>

#include "formats/model/error_model.h"
#include "passes/model/forest/training_set.h"

// What the trees' share of labels within a limit is worth as a probability. Averaging over trees
// draws shares towards the middle: where they say 0.25, 0.20 came true, where they say 0.75, 0.80.

namespace sightline {

// 1 / (1 + exp(-(offset + slope ln(share / (1 - share))))); 0 stays 0 and 1 stays 1. A larger share
// is never less probable.
double on_curve(const ProbabilityCurve& curve, double share);

// Pairs of a share that was predicted and whether the limit was met.
struct PredictedShares {
  std::vector<double> share;
  std::vector<std::uint8_t> is_met;
};

// The curve of greatest likelihood (Platt scaling on the log odds), held to the identity as by 20
// more pairs; shares below 0.005 or above 0.995 are left out, since one miss there would weigh more
// than all others. The identity where nothing is left, or larger shares came true less often.
ProbabilityCurve fit_curve(const PredictedShares& shares);

// Of every labelled case, range and limit of the out-of-fold predictions.
PredictedShares predicted_shares(const TrainingSet& training_set, const PredictedError& predicted);

// Puts all probabilities on the curve.
void put_on_curve(const ProbabilityCurve& curve, PredictedError& predicted);

}  // namespace sightline
