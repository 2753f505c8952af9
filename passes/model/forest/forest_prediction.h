#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/model/error_model.h"
#include "formats/model/regression_forest.h"
#include "passes/model/forest/growing/feature_rows.h"
#include "passes/model/forest/growing/grow_trees.h"
#include "passes/model/forest/training_set.h"

namespace sightline {

// What a forest says of some rows, in their order.
struct ForestPrediction {
  std::vector<double> mean;  // [row]: mean over trees of the mean label of the leaf
  std::vector<double>
      within;  // [row][limit]: mean over trees of the leaf's share of labels <= limit
};

// A forest made ready for many rows: what each leaf answers is worked out once, of which training
// rows fall there.
class PreparedForest {
 public:
  PreparedForest(const RegressionForest& forest, const std::vector<double>& limits, int threads);
  PreparedForest(LabelledTrees forest, const std::vector<double>& limits, int threads);

  // `rows` are indices into `features`, whose columns are those the forest was grown on.
  // Never throws; the same bytes for any thread count.
  [[nodiscard]] ForestPrediction predict(const FeatureRows& features,
                                         const std::vector<std::uint32_t>& rows, int threads) const;

  // What the mean of a row would be with another value of one feature, for each row and feature:
  // the mean that predict() gives of such a row, bit for bit. `others`: [row][feature], the other
  // values. Returns [row][feature].
  [[nodiscard]] std::vector<double> means_with_others(const FeatureRows& features,
                                                      const std::vector<std::uint32_t>& rows,
                                                      const std::vector<float>& others,
                                                      int threads) const;

 private:
  struct Tree {
    std::vector<TreeNode> nodes;
    std::vector<double> answers;  // [leaf][mean, then one share per limit]
  };
  void add_answers(const Tree& tree, const std::vector<const float*>& rows,
                   std::vector<std::uint32_t>& leaves, std::vector<double>& sums) const;

  std::vector<Tree> trees_;
  std::size_t answer_count_ = 0;
};

// What the trees' share of labels within a limit is worth as a probability. Averaging over trees
// draws shares towards the middle: where they say 0.25, 0.20 came true, where they say 0.75, 0.80.

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

// From tracking starts: `within` is [site][look][limit].
PredictedShares predicted_tracking_shares(const TrainingSet& training_set,
                                          const std::vector<double>& within,
                                          const std::vector<double>& limits_m);

// Puts all probabilities on the curve.
void put_on_curve(const ProbabilityCurve& curve, PredictedError& predicted);

// Whether a model can speak for a site at a range: of what its forest decides by, how much lies
// where training was? A feature weighs what its importance is (of out-of-fold predictions); range_m
// and features that help nothing weigh nothing. It lies outside where it is beyond the extremes
// that training saw at this range by more than a margin, a share of their spread.
class Support {
 public:
  Support(const ErrorModel& model, double margin);

  // Of the weight, the share that lies outside; 0 where no feature weighs anything. `row`: the
  // model's features at the range of this index.
  [[nodiscard]] double outside_share(const float* row, std::size_t range) const;
  // More than half.
  [[nodiscard]] bool is_outside(const float* row, std::size_t range) const;

 private:
  const ErrorModel& model_;
  double margin_;
  std::vector<double> weights_;  // [feature], sum 1 or 0
};

}  // namespace sightline
