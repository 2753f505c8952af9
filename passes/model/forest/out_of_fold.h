#pragma once

#include <vector>

#include "formats/annotation/predicted_error.h"
#include "formats/base/result.h"
#include "passes/model/forest/forest_prediction.h"
#include "passes/model/forest/growing/grow_trees.h"
#include "passes/model/forest/training_set.h"
#include "passes/pass/pass_context.h"

namespace sightline {

struct OutOfFoldOptions {
  ForestOptions forest;
  double buffer_m = 25.0;
  std::size_t most_rows = 100000;  // that a forest learns from
};

// Predictions of every site by trees that saw nothing within the buffer of its fold; and, where
// drives are held out, no label of its drive.
struct OutOfFold {
  PredictedError predicted;
  // [feature]: by how much the RMSE over labelled rows rises when the rows of a fold swap their
  // values of this feature, m.
  std::vector<double> importance;
  // By the labels from tracking starts in the leaves of the same trees: mean, [site][look], and
  // share within the limit, [site][look][limit]. Empty where there are no such labels.
  ForestPrediction tracking = {};
};

// `predicted` names ranges and limits; its numbers are filled in. Error: drive-too-short where the
// buffer leaves a fold nothing to learn from; out-of-memory.
Result<OutOfFold> predict_out_of_fold(const PassContext& ctx, const OutOfFoldOptions& options,
                                      const TrainingSet& training_set, PredictedError predicted);

}  // namespace sightline
