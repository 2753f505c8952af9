#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "formats/model/regression_forest.h"
#include "passes/model/forest/growing/tree_rows.h"

namespace sightline {

// A tree as it was grown on a bootstrap sample: a child always comes after its parent, and
// leaf_values[child - nodes.size()] is the mean label that fell there.
struct GrownTree {
  std::vector<TreeNode> nodes;
  std::vector<float> leaf_values;
};

// What a tree learns from: rows[i] has a finite value for each feature, and the label labels[i].
struct TreeSamples {
  std::vector<const float*> rows;
  std::vector<double> labels;
  std::size_t feature_count = 0;
};

struct TreeOptions {
  std::size_t least_leaf_rows = 5;
  double feature_share = 0.4;  // of the features, tried at each split
};

// A label of which many can be added up exactly, in any order: the nearest multiple of 2^-30 m,
// where all labels together are below 2^23 m.
double summable_label(double label);

// A regression tree of a random forest (Breiman 2001) on a bootstrap sample: at each split that
// feature of some drawn ones, and that threshold, which leaves the least squared deviation from the
// means of both sides. Of labels that are summable_label() the same tree, bit for bit, as dlib's
// random_forest_regression_trainer makes of these samples with the same seed, in a fraction of its
// time. `ranks` are those of the samples' rows, which are not empty.
GrownTree grow_tree(const TreeSamples& samples, const RankedColumns& ranks,
                    const TreeOptions& options, std::uint64_t seed);

// Random numbers of one tree, from a Mersenne twister (Matsumoto and Nishimura 1998): the same, bit
// for bit, as dlib::rand draws with the seed text "SEED/0", with which dlib grows the first tree of
// a forest.
class TreeRandom {
 public:
  explicit TreeRandom(std::uint64_t seed);

  // Each number of [begin, end) is equally likely; an empty range returns begin and draws nothing.
  std::size_t in_range(std::size_t begin, std::size_t end);

 private:
  std::mt19937 engine_;
};

}  // namespace sightline
