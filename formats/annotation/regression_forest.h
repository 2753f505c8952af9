#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/result.h"

// A regression forest that remembers its training labels: each leaf knows which labels fell into
// it, so one forest answers "what is the mean?" and "what share is within a limit?" for any limit.

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
  // Per training label: the leaf that its row falls into. No leaf is empty.
  std::vector<std::uint32_t> leaf_of_label;

  [[nodiscard]] std::size_t leaf_count() const { return nodes.size() + 1; }
  friend bool operator==(const RegressionTree&, const RegressionTree&) = default;
};

// Trees times labels, at most: what a reader is ready to hold, 1 GiB of leaves.
inline constexpr std::size_t kMostTreeLabels = std::size_t{1} << 28;

struct RegressionForest {
  std::uint32_t feature_count = 0;
  std::vector<double> labels;  // of the training rows, ascending
  std::vector<float> rows;     // [label][feature]: the training rows themselves
  std::vector<RegressionTree> trees;
};

// Where a row ends up: the number of a leaf.
std::uint32_t leaf_of(const std::vector<TreeNode>& nodes, const float* row);

// Every promise above, but that rows fall where leaf_of_label says: decoding makes that so.
// Error: invalid-artifact, naming the tree.
Result<void> validate(const RegressionForest& forest);
// Six bytes a node, and the training rows once for all trees, which is less than what they come to
// in every tree: shape, order and leaves are not stored but implied.
void encode(const RegressionForest& forest, ByteWriter& writer);
void decode(ByteReader& reader, RegressionForest& forest);

}  // namespace sightline
