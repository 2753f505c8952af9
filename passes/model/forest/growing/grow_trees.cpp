#include "passes/model/forest/growing/grow_trees.h"

#include <algorithm>
#include <exception>
#include <numeric>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/base/random.h"

namespace sightline {
namespace {

// `most` of the samples, which are more, drawn without putting back.
TreeSamples drawn(const TreeSamples& samples, std::size_t most, std::uint64_t seed) {
  std::vector<std::size_t> order(samples.rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(seed);
  TreeSamples some;
  some.feature_count = samples.feature_count;
  for (std::size_t i = 0; i < most; ++i) {
    std::swap(order[i], order[i + random.below(order.size() - i)]);
    some.rows.push_back(samples.rows[order[i]]);
    some.labels.push_back(samples.labels[order[i]]);
  }
  return some;
}

// What remains of a subtree after splits were taken out: the node or leaf at its top, in the grown
// tree's numbers, and how many rows reach it.
struct Remains {
  std::uint32_t top = 0;
  std::uint32_t row_count = 0;
};

// Children come after their parents, so going backwards finishes them first.
std::vector<Remains> take_out_small_sides(const std::vector<TreeNode>& grown,
                                          const std::vector<std::uint32_t>& rows_in_leaf,
                                          std::uint32_t least_leaf_rows) {
  std::vector<Remains> remains(grown.size() + rows_in_leaf.size());
  for (std::size_t leaf = 0; leaf < rows_in_leaf.size(); ++leaf) {
    const std::size_t i = grown.size() + leaf;
    remains[i] = {static_cast<std::uint32_t>(i), rows_in_leaf[leaf]};
  }
  for (std::size_t i = grown.size(); i-- > 0;) {
    const Remains& left = remains[grown[i].left];
    const Remains& right = remains[grown[i].right];
    std::uint32_t top = static_cast<std::uint32_t>(i);
    if (right.row_count < least_leaf_rows) top = left.top;
    if (left.row_count < least_leaf_rows) top = right.top;
    remains[i] = {top, left.row_count + right.row_count};
  }
  return remains;
}

// The nodes that remain, in preorder with leaves from left to right.
std::vector<TreeNode> renumbered(const std::vector<TreeNode>& grown,
                                 const std::vector<Remains>& remains) {
  std::vector<TreeNode> nodes;
  struct Branch {
    std::uint32_t top;
    std::uint32_t parent;
    bool is_right;
  };
  constexpr std::uint32_t kLeaf = 0xffffffffU;  // given its number when the node count is known
  std::vector<Branch> open;
  const auto add_node = [&](std::uint32_t top) {
    const auto number = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back({grown[top].feature, grown[top].threshold, kLeaf, kLeaf});
    open.push_back({remains[grown[top].right].top, number, true});
    open.push_back({remains[grown[top].left].top, number, false});
  };
  std::vector<std::pair<std::uint32_t, bool>> leaves;  // parent, and on which side
  if (!grown.empty() && remains[0].top < grown.size()) add_node(remains[0].top);
  while (!open.empty()) {
    const Branch branch = open.back();
    open.pop_back();
    if (branch.top >= grown.size()) {
      leaves.emplace_back(branch.parent, branch.is_right);
      continue;
    }
    (branch.is_right ? nodes[branch.parent].right : nodes[branch.parent].left) =
        static_cast<std::uint32_t>(nodes.size());
    add_node(branch.top);
  }
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    TreeNode& parent = nodes[leaves[i].first];
    (leaves[i].second ? parent.right : parent.left) = static_cast<std::uint32_t>(nodes.size() + i);
  }
  return nodes;
}

}  // namespace

Result<std::vector<GrownTree>> grow_trees(const FeatureRows& features, const LabelledRows& training,
                                          const ForestOptions& options, std::uint64_t seed,
                                          int threads) {
  SIGHTLINE_CHECK(!training.rows.empty() && training.rows.size() == training.labels.size());
  TreeSamples samples;
  samples.feature_count = features.names.size();
  for (const double label : training.labels) samples.labels.push_back(summable_label(label));
  for (const std::uint32_t row : training.rows) samples.rows.push_back(features.row(row));
  const TreeOptions tree_options{static_cast<std::size_t>(options.least_leaf_rows),
                                 options.feature_share};
  const auto tree_rows = static_cast<std::size_t>(options.tree_rows);
  try {
    // Trees of all rows share their ranks.
    std::optional<RankedColumns> ranks;
    if (samples.rows.size() <= tree_rows) ranks.emplace(samples.rows, samples.feature_count);
    return parallel_map<GrownTree>(
        static_cast<std::size_t>(options.tree_count), threads, [&](std::size_t i) {
          const std::uint64_t tree_seed = mix(seed, i);
          if (ranks) return grow_tree(samples, *ranks, tree_options, tree_seed);
          const TreeSamples own = drawn(samples, tree_rows, tree_seed);
          return grow_tree(own, RankedColumns(own.rows, own.feature_count), tree_options,
                           tree_seed);
        });
  } catch (const std::exception& failure) {
    return Error{ErrorCode::kOutOfMemory,
                 concat("the forest could not be grown: ", failure.what())};
  }
}

Result<LabelledTrees> grow_labelled_trees(const FeatureRows& features, const LabelledRows& training,
                                          const ForestOptions& options, std::uint64_t seed,
                                          int threads) {
  if (training.rows.size() > kMostTreeLabels / static_cast<std::size_t>(options.tree_count)) {
    return Error{ErrorCode::kOutOfMemory,
                 concat(options.tree_count, " trees over ", training.rows.size(),
                        " rows are more than a model can store; use fewer of either")};
  }
  SIGHTLINE_ASSIGN(const std::vector<GrownTree> grown,
                   grow_trees(features, training, options, seed, threads));
  LabelledRows sorted = sorted_by_label(training);
  LabelledTrees labelled;
  for (const std::uint32_t row : sorted.rows) labelled.rows.push_back(features.row(row));
  labelled.labels = std::move(sorted.labels);
  labelled.trees = parallel_map<RegressionTree>(grown.size(), threads, [&](std::size_t i) {
    return labelled_tree(grown[i].nodes, labelled.rows,
                         static_cast<std::uint32_t>(options.least_leaf_rows));
  });
  return labelled;
}

Result<RegressionForest> grow_forest(const FeatureRows& features, const LabelledRows& training,
                                     const ForestOptions& options, std::uint64_t seed,
                                     int threads) {
  SIGHTLINE_ASSIGN(LabelledTrees labelled,
                   grow_labelled_trees(features, training, options, seed, threads));
  RegressionForest forest;
  forest.feature_count = static_cast<std::uint32_t>(features.names.size());
  forest.labels = std::move(labelled.labels);
  forest.rows.reserve(labelled.rows.size() * forest.feature_count);
  for (const float* row : labelled.rows) {
    forest.rows.insert(forest.rows.end(), row, row + forest.feature_count);
  }
  forest.trees = std::move(labelled.trees);
  return forest;
}

LabelledRows sorted_by_label(const LabelledRows& training) {
  std::vector<std::size_t> order(training.rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(training.labels[a], training.rows[a]) <
           std::tie(training.labels[b], training.rows[b]);
  });
  LabelledRows sorted;
  for (const std::size_t i : order) {
    sorted.rows.push_back(training.rows[i]);
    sorted.labels.push_back(training.labels[i]);
  }
  return sorted;
}

RegressionTree labelled_tree(const std::vector<TreeNode>& grown, std::span<const float* const> rows,
                             std::uint32_t least_leaf_rows) {
  std::vector<std::uint32_t> leaves(rows.size());
  find_leaves(grown, rows, leaves);
  std::vector<std::uint32_t> rows_in_leaf(grown.size() + 1, 0);
  for (const std::uint32_t leaf : leaves) ++rows_in_leaf[leaf];
  const std::uint32_t least_rows = std::max(least_leaf_rows, 1U);
  return {renumbered(grown, take_out_small_sides(grown, rows_in_leaf, least_rows))};
}

}  // namespace sightline
