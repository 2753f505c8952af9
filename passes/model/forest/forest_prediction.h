#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/regression_forest.h"
#include "passes/model/forest/feature_rows.h"

namespace sightline {

// What a forest says of some rows, in their order.
struct ForestPrediction {
  std::vector<double> mean;  // [row]: mean over trees of the mean label of the leaf
  std::vector<double>
      within;  // [row][limit]: mean over trees of the leaf's share of labels <= limit
};

// A forest made ready for many rows: what each leaf answers is worked out once.
class PreparedForest {
 public:
  PreparedForest(const RegressionForest& forest, const std::vector<double>& limits);

  // `rows` are indices into `features`, whose columns are those the forest was grown on.
  // Never throws; the same bytes for any thread count.
  [[nodiscard]] ForestPrediction predict(const FeatureRows& features,
                                         const std::vector<std::uint32_t>& rows, int threads) const;

 private:
  // A leaf is a node that leads to itself, so that rows at different depths can walk in step.
  struct Node {
    std::uint32_t feature = 0;
    float threshold = 0.0F;
    std::uint32_t child[2] = {0, 0};  // where the feature is below the threshold, and elsewhere
  };
  struct Tree {
    std::vector<Node> nodes;  // nodes, then leaves
    std::size_t leaf_begin = 0;
    std::uint32_t depth = 0;
    std::vector<double> answers;  // [leaf][mean, then one share per limit]
  };
  static Tree prepare(const RegressionTree& tree, std::vector<double> answers);
  static void walk(const Tree& tree, const float* const* rows, std::uint32_t* places);
  void add_answers(const Tree& tree, const std::vector<const float*>& rows,
                   std::vector<double>& sums) const;

  std::vector<Tree> trees_;
  std::size_t answer_count_ = 0;
};

}  // namespace sightline
