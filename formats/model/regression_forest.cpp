#include "formats/model/regression_forest.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "formats/artifact.h"
#include "formats/base/parallel.h"

namespace sightline {
namespace {

// A node is stored as its feature with two flags, and its threshold. In preorder a left child that
// is a node comes next, and leaves are numbered as they are met, so no index needs storing, and
// whatever can be read is a tree.
constexpr std::uint16_t kLeftIsLeaf = 0x8000;
constexpr std::uint16_t kRightIsLeaf = 0x4000;
constexpr std::uint32_t kFeatureLimit = 0x4000;
constexpr std::size_t kBytesPerNode = sizeof(std::uint16_t) + sizeof(float);

Error invalid_tree(std::size_t tree, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("tree ", tree)};
}

struct Branch {
  std::uint32_t parent;
  bool is_right;
};

std::vector<std::uint16_t> flags_of(const std::vector<TreeNode>& nodes) {
  std::vector<std::uint16_t> flags(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    unsigned bits = nodes[i].feature;
    if (nodes[i].left >= nodes.size()) bits |= kLeftIsLeaf;
    if (nodes[i].right >= nodes.size()) bits |= kRightIsLeaf;
    flags[i] = static_cast<std::uint16_t>(bits);
  }
  return flags;
}

// Gives children their numbers from the flags; false where the flags do not make one tree.
bool number_children(const std::vector<std::uint16_t>& flags, std::vector<TreeNode>& nodes) {
  if (nodes.empty()) return true;
  auto next_leaf = static_cast<std::uint32_t>(nodes.size());
  std::uint32_t next_node = 1;
  std::vector<Branch> open = {{0, true}, {0, false}};
  while (!open.empty()) {
    const Branch branch = open.back();
    open.pop_back();
    const std::uint16_t leaf_flag = branch.is_right ? kRightIsLeaf : kLeftIsLeaf;
    std::uint32_t& child = branch.is_right ? nodes[branch.parent].right : nodes[branch.parent].left;
    if ((flags[branch.parent] & leaf_flag) != 0) {
      child = next_leaf++;
      continue;
    }
    if (next_node == nodes.size()) return false;
    child = next_node++;
    open.push_back({child, true});
    open.push_back({child, false});
  }
  return next_node == nodes.size();
}

Result<void> validate_leaves(const RegressionTree& tree, std::size_t t,
                             const std::vector<const float*>& rows) {
  std::vector<std::uint32_t> leaves(rows.size());
  find_leaves(tree.nodes, rows, leaves);
  std::vector<bool> is_used(tree.leaf_count(), false);
  for (const std::uint32_t leaf : leaves) is_used[leaf] = true;
  if (std::find(is_used.begin(), is_used.end(), false) != is_used.end()) {
    return invalid_tree(t, "found a leaf without a label");
  }
  return {};
}

Result<void> validate_tree(const RegressionForest& forest, std::size_t t,
                           const std::vector<const float*>& rows) {
  const RegressionTree& tree = forest.trees[t];
  for (const TreeNode& node : tree.nodes) {
    if (node.feature >= forest.feature_count || !std::isfinite(node.threshold)) {
      return invalid_tree(t, concat("a split uses feature ", node.feature, " of ",
                                    forest.feature_count, ", or has no finite threshold"));
    }
  }
  std::vector<TreeNode> numbered = tree.nodes;
  if (!number_children(flags_of(tree.nodes), numbered) || numbered != tree.nodes) {
    return invalid_tree(t, "nodes must be in preorder, and leaves from left to right");
  }
  return validate_leaves(tree, t, rows);
}

void decode_nodes(ByteReader& reader, RegressionTree& tree) {
  const std::size_t node_count = reader.get_count(kBytesPerNode);
  std::vector<std::uint16_t> flags(node_count);
  tree.nodes.resize(node_count);
  for (std::size_t i = 0; i < node_count; ++i) {
    reader.get(flags[i]);
    reader.get(tree.nodes[i].threshold);
    tree.nodes[i].feature = flags[i] & (kFeatureLimit - 1);
  }
  if (!reader.ok() || !number_children(flags, tree.nodes)) reader.fail();
}

bool asks_known_features(const RegressionForest& forest) {
  return std::ranges::all_of(forest.trees, [&](const RegressionTree& tree) {
    return std::ranges::all_of(
        tree.nodes, [&](const TreeNode& node) { return node.feature < forest.feature_count; });
  });
}

// Rows that go down a tree in step: the processor works on one while it waits for another.
constexpr std::size_t kLanes = 8;

// places[lane] becomes the number of a leaf, counted from the node count on.
void walk(const std::vector<TreeNode>& nodes, const float* const* rows, std::uint32_t* places) {
  const auto node_count = static_cast<std::uint32_t>(nodes.size());
  std::fill_n(places, kLanes, 0U);
  for (bool is_open = node_count > 0; is_open;) {
    is_open = false;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      // Masks instead of branches, which would be guessed wrong half the time.
      const std::uint32_t place = places[lane];
      const std::uint32_t walks = place < node_count ? ~0U : 0U;
      const TreeNode& node = nodes[place & walks];
      const std::uint32_t goes_left = rows[lane][node.feature] < node.threshold ? ~0U : 0U;
      const std::uint32_t child = node.right ^ ((node.left ^ node.right) & goes_left);
      places[lane] = place ^ ((place ^ child) & walks);
      is_open |= places[lane] < node_count;
    }
  }
}

}  // namespace

std::uint32_t leaf_of(const std::vector<TreeNode>& nodes, const float* row) {
  std::uint32_t i = 0;
  while (i < nodes.size()) {
    i = row[nodes[i].feature] < nodes[i].threshold ? nodes[i].left : nodes[i].right;
  }
  return i - static_cast<std::uint32_t>(nodes.size());
}

void find_leaves(const std::vector<TreeNode>& nodes, std::span<const float* const> rows,
                 std::span<std::uint32_t> leaves) {
  const auto node_count = static_cast<std::uint32_t>(nodes.size());
  std::size_t first = 0;
  for (; first + kLanes <= rows.size(); first += kLanes) {
    walk(nodes, &rows[first], &leaves[first]);
    for (std::size_t lane = 0; lane < kLanes; ++lane) leaves[first + lane] -= node_count;
  }
  for (; first < rows.size(); ++first) leaves[first] = leaf_of(nodes, rows[first]);
}

std::vector<const float*> training_rows(const RegressionForest& forest) {
  std::vector<const float*> rows(forest.labels.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = &forest.rows[i * forest.feature_count];
  return rows;
}

Result<void> validate(const RegressionForest& forest) {
  const bool is_sorted = std::is_sorted(forest.labels.begin(), forest.labels.end());
  const bool is_finite = std::all_of(forest.labels.begin(), forest.labels.end(),
                                     [](double label) { return std::isfinite(label); });
  if (forest.labels.empty() || forest.trees.empty() || !is_sorted || !is_finite) {
    return Error{ErrorCode::kInvalidArtifact,
                 "found a forest without trees, or labels that are not finite and ascending"};
  }
  if (forest.feature_count == 0 || forest.feature_count > kFeatureLimit) {
    return Error{ErrorCode::kInvalidArtifact, concat("found ", forest.feature_count,
                                                     " features, expected 1 to ", kFeatureLimit)};
  }
  const bool are_rows_finite =
      std::ranges::all_of(forest.rows, [](float value) { return std::isfinite(value); });
  if (!are_rows_finite || forest.rows.size() != forest.labels.size() * forest.feature_count) {
    return Error{ErrorCode::kInvalidArtifact,
                 "found training rows that are not finite, or not one for each label"};
  }
  const std::vector<const float*> rows = training_rows(forest);
  std::vector<Result<void>> valid(forest.trees.size());
  parallel_for(valid.size(), 0, [&](std::size_t t) { valid[t] = validate_tree(forest, t, rows); });
  for (const Result<void>& of_tree : valid) SIGHTLINE_TRY(of_tree);
  return {};
}

Result<void> visit_behind_feature_count(const RegressionForest& forest, const ByteSink& sink) {
  SIGHTLINE_TRY(visit_array(forest.labels, sink));
  SIGHTLINE_TRY(visit_array(forest.rows, sink));
  ByteWriter count;
  count.put<std::uint64_t>(forest.trees.size());
  SIGHTLINE_TRY(sink(count.bytes()));
  for (const RegressionTree& tree : forest.trees) {
    const std::vector<std::uint16_t> flags = flags_of(tree.nodes);
    ByteWriter writer;
    writer.put<std::uint64_t>(tree.nodes.size());
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
      writer.put(flags[i]);
      writer.put(tree.nodes[i].threshold);
    }
    SIGHTLINE_TRY(sink(writer.bytes()));
  }
  return {};
}

void encode(const RegressionForest& forest, ByteWriter& writer) {
  writer.put(forest.feature_count);
  encode_by_visiting([&](const ByteSink& sink) { return visit_behind_feature_count(forest, sink); },
                     writer);
}

void decode(ByteReader& reader, RegressionForest& forest) {
  reader.get(forest.feature_count);
  decode_behind_feature_count(reader, forest);
}

void decode_behind_feature_count(ByteReader& reader, RegressionForest& forest) {
  reader.get_array(forest.labels);
  reader.get_array(forest.rows);
  forest.trees.resize(reader.get_count(sizeof(std::uint64_t)));
  for (RegressionTree& tree : forest.trees) {
    if (!reader.ok()) return;
    decode_nodes(reader, tree);
  }
  const bool are_rows_whole = forest.feature_count > 0 &&
                              forest.rows.size() % forest.feature_count == 0 &&
                              forest.rows.size() / forest.feature_count == forest.labels.size();
  const bool are_few =
      forest.trees.empty() || forest.labels.size() <= kMostTreeLabels / forest.trees.size();
  if (!are_rows_whole || !are_few || !asks_known_features(forest)) reader.fail();
}

}  // namespace sightline
