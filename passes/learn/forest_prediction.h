#pragma once

#include <cstdint>
#include <vector>

#include "formats/regression_forest.h"
#include "passes/learn/feature_rows.h"

namespace sightline {

// What a forest says of some rows, in their order.
struct ForestPrediction {
  std::vector<double> mean;    // [row]: mean over trees of the mean label of the leaf
  std::vector<double> within;  // [row][limit]: mean over trees of the leaf's share of labels <= limit
};

// A forest made ready for many rows: what each leaf answers is worked out once.
class PreparedForest {
 public:
  PreparedForest(const RegressionForest& forest, const std::vector<double>& limits);

  // `rows` are indices into `features`, whose columns are those the forest was grown on.
  // Never throws; the same bytes for any thread count.
  [[nodiscard]] ForestPrediction predict(const FeatureRows& features,
                                         const std::vector<std::uint32_t>& rows,
                                         int threads) const;

 private:
  struct Tree {
    std::vector<TreeNode> nodes;
    std::vector<double> answers;  // [leaf][mean, then one share per limit]
  };
  std::vector<Tree> trees_;
  std::size_t answer_count_ = 0;
};

}  // namespace sightline
