#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/regression_forest.h"
#include "passes/model/forest/feature_rows.h"
#include "passes/model/forest/labelled_rows.h"

namespace sightline {

// The same rows and labels, ascending by label, then by row.
LabelledRows sorted_by_label(const LabelledRows& training);

// Drops all training rows down a grown tree and keeps where each fell, as in quantile regression
// forests (Meinshausen 2006). A split of which one side got fewer rows than `least_leaf_rows` is
// taken out, its rows go down the other side: no leaf of the result is smaller, unless the whole
// tree is. `rows` are in the order of their labels.
RegressionTree labelled_tree(const std::vector<TreeNode>& grown, const FeatureRows& features,
                             const std::vector<std::uint32_t>& rows, std::uint32_t least_leaf_rows);

}  // namespace sightline
