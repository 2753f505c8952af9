#include "passes/learn/forest_prediction.h"

#include <algorithm>

#include "compiler/base/parallel.h"
#include "passes/learn/labelled_tree.h"

namespace sightline {
namespace {

// Rows of one block go down a tree before the next tree is touched, so that a tree stays in the
// processor's nearest cache.
constexpr std::size_t kRowsPerBlock = 512;

std::vector<double> answers_of(const RegressionTree& tree, const std::vector<double>& labels,
                               const std::vector<double>& limits) {
  const std::size_t answer_count = 1 + limits.size();
  std::vector<double> answers(tree.leaf_count() * answer_count, 0.0);
  std::vector<double> label_count(tree.leaf_count(), 0.0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    double* answer = &answers[tree.leaf_of_label[i] * answer_count];
    label_count[tree.leaf_of_label[i]] += 1.0;
    answer[0] += labels[i];
    for (std::size_t limit = 0; limit < limits.size(); ++limit) {
      if (labels[i] <= limits[limit]) answer[1 + limit] += 1.0;
    }
  }
  for (std::size_t i = 0; i < answers.size(); ++i) answers[i] /= label_count[i / answer_count];
  return answers;
}

}  // namespace

PreparedForest::PreparedForest(const RegressionForest& forest, const std::vector<double>& limits)
    : answer_count_(1 + limits.size()) {
  for (const RegressionTree& tree : forest.trees) {
    trees_.push_back({tree.nodes, answers_of(tree, forest.labels, limits)});
  }
}

ForestPrediction PreparedForest::predict(const FeatureRows& features,
                                         const std::vector<std::uint32_t>& rows,
                                         int threads) const {
  const std::size_t limit_count = answer_count_ - 1;
  const auto tree_count = static_cast<double>(trees_.size());
  ForestPrediction prediction;
  prediction.mean.resize(rows.size());
  prediction.within.resize(rows.size() * limit_count);
  const auto predict_block = [&](std::size_t block) {
    const std::size_t first = block * kRowsPerBlock;
    const std::size_t last = std::min(first + kRowsPerBlock, rows.size());
    std::vector<double> sums((last - first) * answer_count_, 0.0);
    for (const Tree& tree : trees_) {
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t leaf = leaf_of(tree.nodes, features.row(rows[i]));
        const double* answer = &tree.answers[leaf * answer_count_];
        double* sum = &sums[(i - first) * answer_count_];
        for (std::size_t k = 0; k < answer_count_; ++k) sum[k] += answer[k];
      }
    }
    for (std::size_t i = first; i < last; ++i) {
      const double* sum = &sums[(i - first) * answer_count_];
      prediction.mean[i] = sum[0] / tree_count;
      for (std::size_t limit = 0; limit < limit_count; ++limit) {
        prediction.within[i * limit_count + limit] = sum[1 + limit] / tree_count;
      }
    }
  };
  parallel_for((rows.size() + kRowsPerBlock - 1) / kRowsPerBlock, threads, predict_block);
  return prediction;
}

}  // namespace sightline
