#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/result.h"

// A regression forest that remembers its training rows and their labels: which labels lie in a leaf
// finds where their rows fall, so one forest answers "what is the mean?" and "what share is within
// a limit?" for any limit.

namespace sightline {

// One split: a row goes left when its feature is below the threshold. A child below the tree's node
// count is a node, any other is leaf (child - node count).
struct TreeNode {
  std::uint32_t feature = 0;
  float threshold = 0.0F;
  std::uint32_t left = 0;
  std::uint32_t right = 0;
  friend bool operator==(const TreeNode&, const TreeNode&) = default;
};

// Nodes in preorder, leaves from left to right; a tree without nodes is one leaf.
struct RegressionTree {
  std::vector<TreeNode> nodes;

  [[nodiscard]] std::size_t leaf_count() const { return nodes.size() + 1; }
  friend bool operator==(const RegressionTree&, const RegressionTree&) = default;
};

// Trees times labels, at most: what a reader is ready to hold, 1 GiB of leaves.
inline constexpr std::size_t kMostTreeLabels = std::size_t{1} << 28;

struct RegressionForest {
  std::uint32_t feature_count = 0;
  std::vector<double> labels;         // of the training rows, ascending
  std::vector<float> rows;            // [label][feature]: the training rows themselves
  std::vector<RegressionTree> trees;  // every leaf of each has a training row
};

// Where a row ends up: the number of a leaf.
std::uint32_t leaf_of(const std::vector<TreeNode>& nodes, const float* row);

// The same of many rows, several at a time: leaves[i] is that of rows[i].
void find_leaves(const std::vector<TreeNode>& nodes, std::span<const float* const> rows,
                 std::span<std::uint32_t> leaves);

// Of the training rows, in their order; good as long as the forest stays.
std::vector<const float*> training_rows(const RegressionForest& forest);

// Every promise above. Error: invalid-artifact, naming the tree.
Result<void> validate(const RegressionForest& forest);
// Six bytes a node, and the training rows once for all trees: shape and order are not stored but
// implied.
void encode(const RegressionForest& forest, ByteWriter& writer);
// The same bytes but for feature_count, which precedes them; piece by piece.
Result<void> visit_behind_feature_count(const RegressionForest& forest, const ByteSink& sink);
void decode(ByteReader& reader, RegressionForest& forest);
// The rest, where feature_count is known.
void decode_behind_feature_count(ByteReader& reader, RegressionForest& forest);

}  // namespace sightline
