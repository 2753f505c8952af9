#include "passes/model/forest/forest_prediction.h"

#include <algorithm>
#include <utility>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

// Rows of one block go down a tree before the next tree is touched, so that a tree stays in the
// processor's nearest cache.
constexpr std::size_t kRowsPerBlock = 512;

// Rows that walk down a tree in step: the processor works on one while it waits for another.
constexpr std::size_t kLanes = 8;
static_assert(kRowsPerBlock % kLanes == 0);

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
    trees_.push_back(prepare(tree, answers_of(tree, forest.labels, limits)));
  }
}

PreparedForest::Tree PreparedForest::prepare(const RegressionTree& tree,
                                             std::vector<double> answers) {
  Tree prepared;
  prepared.leaf_begin = tree.nodes.size();
  prepared.answers = std::move(answers);
  for (const TreeNode& node : tree.nodes) {
    prepared.nodes.push_back({node.feature, node.threshold, {node.left, node.right}});
  }
  for (std::size_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    const auto self = static_cast<std::uint32_t>(prepared.leaf_begin + leaf);
    prepared.nodes.push_back({0, 0.0F, {self, self}});
  }
  std::vector<std::uint32_t> depth(prepared.nodes.size(), 0);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    depth[tree.nodes[i].left] = depth[tree.nodes[i].right] = depth[i] + 1;
  }
  prepared.depth = *std::max_element(depth.begin(), depth.end());
  return prepared;
}

void PreparedForest::walk(const Tree& tree, const float* const* rows, std::uint32_t* places) {
  const Node* nodes = tree.nodes.data();
  std::fill_n(places, kLanes, 0U);
  for (std::uint32_t step = 0; step < tree.depth; ++step) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const Node& node = nodes[places[lane]];
      // An index instead of a branch, which would be guessed wrong half the time.
      places[lane] = node.child[rows[lane][node.feature] < node.threshold ? 0 : 1];
    }
  }
}

void PreparedForest::add_answers(const Tree& tree, const std::vector<const float*>& rows,
                                 std::vector<double>& sums) const {
  std::uint32_t places[kLanes];
  for (std::size_t first = 0; first < rows.size(); first += kLanes) {
    walk(tree, &rows[first], places);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const double* answer = &tree.answers[(places[lane] - tree.leaf_begin) * answer_count_];
      double* sum = &sums[(first + lane) * answer_count_];
      for (std::size_t k = 0; k < answer_count_; ++k) sum[k] += answer[k];
    }
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
    // The last block is filled up with its first row, whose extra answers nobody reads.
    std::vector<const float*> inputs(kRowsPerBlock, features.row(rows[first]));
    for (std::size_t i = first; i < last; ++i) inputs[i - first] = features.row(rows[i]);
    std::vector<double> sums(kRowsPerBlock * answer_count_, 0.0);
    for (const Tree& tree : trees_) add_answers(tree, inputs, sums);
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
