#include "passes/model/forest/growing/grow_trees.h"

#include <algorithm>
#include <exception>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "passes/model/forest/growing/labelled_tree.h"

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
                 std::string("the forest could not be grown: ") + failure.what()};
  }
}

Result<LabelledTrees> grow_labelled_trees(const FeatureRows& features, const LabelledRows& training,
                                          const ForestOptions& options, std::uint64_t seed,
                                          int threads) {
  if (training.rows.size() > kMostTreeLabels / static_cast<std::size_t>(options.tree_count)) {
    return Error{ErrorCode::kOutOfMemory,
                 std::to_string(options.tree_count) + " trees over " +
                     std::to_string(training.rows.size()) +
                     " rows are more than a model can hold; fewer of either"};
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

}  // namespace sightline
