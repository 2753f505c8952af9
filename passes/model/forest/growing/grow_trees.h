#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/model/regression_forest.h"
#include "passes/model/forest/growing/feature_rows.h"
#include "passes/model/forest/growing/grow_tree.h"

namespace sightline {

// Which rows to learn, and what: labels[i] belongs to features.row(rows[i]).
struct LabelledRows {
  std::vector<std::uint32_t> rows;
  std::vector<double> labels;
};

// The same rows and labels, ascending by label, then by row.
LabelledRows sorted_by_label(const LabelledRows& training);

// Drops all training rows down a grown tree, as in quantile regression forests (Meinshausen 2006),
// and takes out splits of which one side got fewer rows than `least_leaf_rows`; their rows go down
// the other side: no leaf of the result is smaller, unless the whole tree is.
RegressionTree labelled_tree(const std::vector<TreeNode>& grown, std::span<const float* const> rows,
                             std::uint32_t least_leaf_rows);

struct ForestOptions {
  int tree_count = 200;
  int least_leaf_rows = 5;
  double feature_share = 0.4;  // of the features, tried at each split
  int tree_rows = 8000;        // of more training rows, a tree grows on as many drawn for it
};

// Trees of a random forest (Breiman 2001), each from its own bootstrap sample and with a random
// choice of features at each split. Time is bounded: where rows are many, a tree sees some of them;
// together the trees see all. Tree i depends on the set, the options and mix(seed, i) alone.
// At most `threads` trees are grown at a time. Error: out-of-memory.
Result<std::vector<GrownTree>> grow_trees(const FeatureRows& features, const LabelledRows& training,
                                          const ForestOptions& options, std::uint64_t seed,
                                          int threads);

// Grown and labelled: what prediction needs.
struct LabelledTrees {
  std::vector<const float*> rows;  // that they learnt from, ascending by label
  std::vector<double> labels;      // of these rows
  std::vector<RegressionTree> trees;
};
// The rows are those of `features`, which must stay. Error: out-of-memory.
Result<LabelledTrees> grow_labelled_trees(const FeatureRows& features, const LabelledRows& training,
                                          const ForestOptions& options, std::uint64_t seed,
                                          int threads);

// The same with rows of its own.
Result<RegressionForest> grow_forest(const FeatureRows& features, const LabelledRows& training,
                                     const ForestOptions& options, std::uint64_t seed, int threads);

}  // namespace sightline
