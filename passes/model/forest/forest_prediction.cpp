#include "passes/model/forest/forest_prediction.h"

#include <algorithm>
#include <utility>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

// Rows of one block go down a tree before the next tree is touched, so that a tree stays in the
// processor's nearest cache.
constexpr std::size_t kRowsPerBlock = 512;

std::vector<double> answers_of(const std::vector<std::uint32_t>& leaf_of_label,
                               std::size_t leaf_count, const std::vector<double>& labels,
                               const std::vector<double>& limits) {
  const std::size_t answer_count = 1 + limits.size();
  std::vector<double> answers(leaf_count * answer_count, 0.0);
  std::vector<double> label_count(leaf_count, 0.0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    double* answer = &answers[leaf_of_label[i] * answer_count];
    label_count[leaf_of_label[i]] += 1.0;
    answer[0] += labels[i];
    for (std::size_t limit = 0; limit < limits.size(); ++limit) {
      if (labels[i] <= limits[limit]) answer[1 + limit] += 1.0;
    }
  }
  for (std::size_t i = 0; i < answers.size(); ++i) answers[i] /= label_count[i / answer_count];
  return answers;
}

// A leaf's number, from the node `at` on.
std::uint32_t leaf_from(const std::vector<TreeNode>& nodes, std::uint32_t at, const float* row) {
  while (at < nodes.size()) {
    at = row[nodes[at].feature] < nodes[at].threshold ? nodes[at].left : nodes[at].right;
  }
  return at - static_cast<std::uint32_t>(nodes.size());
}

// A row, and of each feature another value.
struct RowAndOthers {
  float* row;
  const float* others;
};

// A feature whose other value leads to another leaf.
struct Parting {
  std::uint32_t feature;
  std::uint32_t leaf;
};

// The leaf of the row, and where each feature would lead alone: its way parts from the row's at the
// first split that it decides otherwise.
std::uint32_t leaf_and_partings(const std::vector<TreeNode>& nodes, const RowAndOthers& given,
                                std::vector<std::uint8_t>& has_parted,
                                std::vector<Parting>& partings) {
  partings.clear();
  std::uint32_t at = 0;
  while (at < nodes.size()) {
    const TreeNode& node = nodes[at];
    const bool goes_left = given.row[node.feature] < node.threshold;
    const bool other_goes_left = given.others[node.feature] < node.threshold;
    if (goes_left != other_goes_left && has_parted[node.feature] == 0) {
      has_parted[node.feature] = 1;
      const float own = std::exchange(given.row[node.feature], given.others[node.feature]);
      const std::uint32_t side = other_goes_left ? node.left : node.right;
      partings.push_back({node.feature, leaf_from(nodes, side, given.row)});
      given.row[node.feature] = own;
    }
    at = goes_left ? node.left : node.right;
  }
  for (const Parting& parting : partings) has_parted[parting.feature] = 0;
  return at - static_cast<std::uint32_t>(nodes.size());
}

}  // namespace

PreparedForest::PreparedForest(const RegressionForest& forest, const std::vector<double>& limits,
                               int threads)
    : PreparedForest(LabelledTrees{training_rows(forest), forest.labels, forest.trees}, limits,
                     threads) {}

PreparedForest::PreparedForest(LabelledTrees forest, const std::vector<double>& limits, int threads)
    : trees_(forest.trees.size()), answer_count_(1 + limits.size()) {
  parallel_for(trees_.size(), threads, [&](std::size_t t) {
    std::vector<TreeNode>& nodes = forest.trees[t].nodes;
    std::vector<std::uint32_t> leaves(forest.rows.size());
    find_leaves(nodes, forest.rows, leaves);
    trees_[t].answers = answers_of(leaves, nodes.size() + 1, forest.labels, limits);
    trees_[t].nodes = std::move(nodes);
  });
}

void PreparedForest::add_answers(const Tree& tree, const std::vector<const float*>& rows,
                                 std::vector<std::uint32_t>& leaves,
                                 std::vector<double>& sums) const {
  find_leaves(tree.nodes, rows, leaves);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double* answer = &tree.answers[leaves[i] * answer_count_];
    double* sum = &sums[i * answer_count_];
    for (std::size_t k = 0; k < answer_count_; ++k) sum[k] += answer[k];
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
    std::vector<const float*> inputs;
    for (std::size_t i = first; i < last; ++i) inputs.push_back(features.row(rows[i]));
    std::vector<std::uint32_t> leaves(inputs.size());
    std::vector<double> sums(inputs.size() * answer_count_, 0.0);
    for (const Tree& tree : trees_) add_answers(tree, inputs, leaves, sums);
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

std::vector<double> PreparedForest::means_with_others(const FeatureRows& features,
                                                      const std::vector<std::uint32_t>& rows,
                                                      const std::vector<float>& others,
                                                      int threads) const {
  constexpr std::size_t kRowsWithOthers = 32;  // whose sums stay in the nearest caches
  const std::size_t feature_count = features.names.size();
  const auto tree_count = static_cast<double>(trees_.size());
  std::vector<double> sums(rows.size() * feature_count, 0.0);
  const auto add_block = [&](std::size_t block) {
    const std::size_t first = block * kRowsWithOthers;
    const std::size_t last = std::min(first + kRowsWithOthers, rows.size());
    std::vector<float> own;  // rows of which single values are exchanged
    for (std::size_t i = first; i < last; ++i) {
      own.insert(own.end(), features.row(rows[i]), features.row(rows[i]) + feature_count);
    }
    std::vector<std::uint8_t> has_parted(feature_count, 0);
    std::vector<Parting> partings;
    std::vector<double> parted_sums;
    for (const Tree& tree : trees_) {
      for (std::size_t i = first; i < last; ++i) {
        double* sum = &sums[i * feature_count];
        const std::uint32_t leaf = leaf_and_partings(
            tree.nodes, {&own[(i - first) * feature_count], &others[i * feature_count]}, has_parted,
            partings);
        // Added tree by tree, as predict() adds.
        parted_sums.clear();
        for (const Parting& parting : partings) {
          parted_sums.push_back(sum[parting.feature] + tree.answers[parting.leaf * answer_count_]);
        }
        const double answer = tree.answers[leaf * answer_count_];
        for (std::size_t f = 0; f < feature_count; ++f) sum[f] += answer;
        for (std::size_t k = 0; k < partings.size(); ++k) {
          sum[partings[k].feature] = parted_sums[k];
        }
      }
    }
    for (std::size_t i = first * feature_count; i < last * feature_count; ++i)
      sums[i] /= tree_count;
  };
  parallel_for((rows.size() + kRowsWithOthers - 1) / kRowsWithOthers, threads, add_block);
  return sums;
}

}  // namespace sightline
