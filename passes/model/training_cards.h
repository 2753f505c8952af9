#pragma once

#include <vector>

#include "formats/annotation/predicted_error.h"
#include "formats/model/error_model.h"
#include "passes/model/forest/training_set.h"
#include "passes/pass/pass_context.h"

// What an error model says of itself; part of train-model.

namespace sightline {

// Least and greatest value of each feature among labelled rows, per range. `importance`: one a
// feature.
std::vector<FeatureCard> feature_cards(const TrainingSet& training_set,
                                       const std::vector<double>& importance);
void warn_of_constant_factors(const PassContext& ctx, const std::vector<FeatureCard>& cards);

// How well the out-of-fold means fit, with and without history.
std::vector<RangeCard> range_cards(const TrainingSet& training_set,
                                   const PredictedError& predicted);

// What the out-of-fold choice by the mean reaches in each kind of place that has labels.
std::vector<KindCard> kind_cards(const TrainingSet& training_set, const PredictedError& predicted);

}  // namespace sightline
