#pragma once

#include <cstdint>
#include <vector>

#include "compiler/base/result.h"
#include "compiler/pipeline/pass_context.h"
#include "formats/predicted_error.h"
#include "formats/sites.h"
#include "passes/learn/feature_rows.h"
#include "passes/learn/folds.h"
#include "passes/learn/grow_trees.h"

namespace sightline {

// All that there is to learn from.
struct Lesson {
  FeatureRows features;                 // of all sites, with a label or without
  std::vector<std::uint8_t> has_label;  // [site]
  std::vector<double> labels;           // [site][range]; 0 where there is none
  std::size_t range_count = 0;
  Folds folds;
};

struct OutOfFoldOptions {
  ForestOptions forest;
  double buffer_m = 25.0;
};

// Predictions of every site by trees that saw nothing within the buffer of its fold.
struct OutOfFold {
  PredictedError predicted;
  // [feature]: by how much the RMSE over labelled rows rises when the rows of a fold swap their
  // values of this feature, m.
  std::vector<double> importance;
};

// The labelled rows of the sites where `leave_out` is 0.
TrainingSet labelled_rows(const Lesson& lesson, const std::vector<std::uint8_t>& leave_out);

// `predicted` names ranges and limits; its numbers are filled in. Error: drive-too-short where the
// buffer leaves a fold nothing to learn from; out-of-memory.
Result<OutOfFold> predict_out_of_fold(const PassContext& ctx, const OutOfFoldOptions& options,
                                      const Sites& sites, const Lesson& lesson,
                                      PredictedError predicted);

}  // namespace sightline
