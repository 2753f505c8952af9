#include "passes/model/forest/grow_trees.h"

#include <dlib/random_forest.h>

#include <algorithm>
#include <exception>
#include <numeric>
#include <string>

#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "passes/model/forest/labelled_tree.h"

namespace sightline {
namespace {

// dlib asks a feature extractor for numbers; ours reads them where they lie instead of copying each
// row into a matrix of its own, which halves the time to grow.
class RowReader {
 public:
  using feature = std::uint32_t;
  using sample_type = const float*;

  RowReader() = default;
  explicit RowReader(std::size_t feature_count) : feature_count_(feature_count) {}

  void setup(const std::vector<sample_type>&, const std::vector<double>&) {}
  void get_random_features(dlib::rand& random, std::size_t count,
                           std::vector<feature>& chosen) const {
    // As dlib's dense_feature_extractor draws them, so that its forests can judge ours.
    chosen.resize(feature_count_);
    for (feature i = 0; i < feature_count_; ++i) chosen[i] = i;
    count = std::min(count, feature_count_);
    for (std::size_t i = 0; i < count; ++i) {
      const auto other = random.get_integer_in_range(static_cast<long long>(i),
                                                     static_cast<long long>(feature_count_));
      std::swap(chosen[i], chosen[static_cast<std::size_t>(other)]);
    }
    chosen.resize(count);
  }
  double extract_feature_value(const sample_type& row, const feature& index) const {
    return row[index];
  }
  [[nodiscard]] std::size_t max_num_feats() const { return feature_count_; }

 private:
  std::size_t feature_count_ = 0;
};

struct Samples {
  std::vector<const float*> rows;
  std::vector<double> labels;
};

// One tree a call: dlib grows the trees of one call on as many threads as the machine has, whatever
// we were told, and numbers their seeds itself.
GrownTree grow_tree(const Samples& samples, std::size_t feature_count, const ForestOptions& options,
                    std::uint64_t seed) {
  dlib::random_forest_regression_trainer<RowReader> trainer;
  trainer.set_feature_extractor(RowReader(feature_count));
  trainer.set_num_trees(1);
  trainer.set_min_samples_per_leaf(static_cast<std::size_t>(options.least_leaf_rows));
  trainer.set_feature_subsampling_fraction(options.feature_share);
  trainer.set_seed(std::to_string(seed) + "/");
  const auto forest = trainer.train(samples.rows, samples.labels);
  GrownTree tree;
  for (const auto& node : forest.get_internal_tree_nodes()[0]) {
    tree.nodes.push_back({node.split_feature, node.split_threshold, node.left, node.right});
  }
  tree.leaf_values = forest.get_tree_leaves()[0];
  return tree;
}

// At most `most` of the samples, drawn without putting back; all of them where they are no more.
Samples drawn(const Samples& samples, std::size_t most, std::uint64_t seed) {
  if (samples.rows.size() <= most) return samples;
  std::vector<std::size_t> order(samples.rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(seed);
  Samples some;
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
  Samples samples;
  samples.labels = training.labels;
  for (const std::uint32_t row : training.rows) samples.rows.push_back(features.row(row));
  try {
    return parallel_map<GrownTree>(
        static_cast<std::size_t>(options.tree_count), threads, [&](std::size_t i) {
          const std::uint64_t tree_seed = mix(seed, i);
          const Samples own =
              drawn(samples, static_cast<std::size_t>(options.tree_rows), tree_seed);
          return grow_tree(own, features.names.size(), options, tree_seed);
        });
  } catch (const std::exception& failure) {
    return Error{ErrorCode::kOutOfMemory,
                 std::string("the forest could not be grown: ") + failure.what(), "", ""};
  }
}

Result<RegressionForest> grow_forest(const FeatureRows& features, const LabelledRows& training,
                                     const ForestOptions& options, std::uint64_t seed,
                                     int threads) {
  if (training.rows.size() > kMostTreeLabels / static_cast<std::size_t>(options.tree_count)) {
    return Error{ErrorCode::kOutOfMemory,
                 std::to_string(options.tree_count) + " trees over " +
                     std::to_string(training.rows.size()) +
                     " rows are more than a model can hold; fewer of either",
                 "", ""};
  }
  SIGHTLINE_ASSIGN(const std::vector<GrownTree> grown,
                   grow_trees(features, training, options, seed, threads));
  const LabelledRows sorted = sorted_by_label(training);
  RegressionForest forest;
  forest.feature_count = static_cast<std::uint32_t>(features.names.size());
  forest.labels = sorted.labels;
  for (const std::uint32_t row : sorted.rows) {
    const float* values = features.row(row);
    forest.rows.insert(forest.rows.end(), values, values + forest.feature_count);
  }
  forest.trees = parallel_map<RegressionTree>(grown.size(), threads, [&](std::size_t i) {
    return labelled_tree(grown[i].nodes, features, sorted.rows,
                         static_cast<std::uint32_t>(options.least_leaf_rows));
  });
  return forest;
}

}  // namespace sightline
