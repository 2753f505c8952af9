#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/model/regression_forest.h"
#include "passes/model/forest/growing/labelled_rows.h"

namespace sightline {

// The same rows and labels, ascending by label, then by row.
LabelledRows sorted_by_label(const LabelledRows& training);

// Drops all training rows down a grown tree, as in quantile regression forests (Meinshausen 2006),
// and takes out splits of which one side got fewer rows than `least_leaf_rows`; their rows go down
// the other side: no leaf of the result is smaller, unless the whole tree is.
RegressionTree labelled_tree(const std::vector<TreeNode>& grown, std::span<const float* const> rows,
                             std::uint32_t least_leaf_rows);

}  // namespace sightline
