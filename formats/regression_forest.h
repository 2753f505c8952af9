#pragma once

#include <cstdint>
#include <vector>

#include "compiler/base/bytes.h"
#include "compiler/base/result.h"

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
  // Per training label: the leaf it fell into. No leaf is empty.
  std::vector<std::uint32_t> leaf_of_label;

  [[nodiscard]] std::size_t leaf_count() const { return nodes.size() + 1; }
  friend bool operator==(const RegressionTree&, const RegressionTree&) = default;
};

struct RegressionForest {
  std::uint32_t feature_count = 0;
  std::vector<double> labels;  // of the training rows, ascending
  std::vector<RegressionTree> trees;
};

// Every promise above. Error: invalid-artifact, naming the tree.
Result<void> validate(const RegressionForest& forest);
// Six bytes a node and two or four a label and tree: shape and order are not stored but implied.
void encode(const RegressionForest& forest, ByteWriter& writer);
void decode(ByteReader& reader, RegressionForest& forest);

}  // namespace sightline
