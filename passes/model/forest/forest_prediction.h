#pragma once

#include <cstdint>
#include <vector>

#include "formats/model/regression_forest.h"
#include "passes/model/forest/growing/feature_rows.h"
#include "passes/model/forest/growing/grow_trees.h"

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

}  // namespace sightline
