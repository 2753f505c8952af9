#include "passes/model/forest/grow_tree.h"

#include <dlib/rand.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>

#include "passes/model/forest/ranked_columns.h"

namespace sightline {
namespace {

// Rows [begin, end) of the sample, which one node has.
struct Part {
  double label_sum = 0.0;
  std::size_t begin = 0;
  std::size_t end = 0;
  std::uint32_t node = 0;

  [[nodiscard]] std::size_t size() const { return end - begin; }
  [[nodiscard]] float mean() const {
    return static_cast<float>(label_sum / static_cast<double>(size()));
  }
};

struct Split {
  double score = -std::numeric_limits<double>::infinity();
  double left_sum = 0.0;
  std::size_t at = 0;  // where the right side begins
  std::uint32_t feature = 0;
};

class TreeGrower {
 public:
  TreeGrower(const TreeSamples& samples, const TreeOptions& options, std::uint64_t seed);
  GrownTree grow();

 private:
  [[nodiscard]] Part draw_bootstrap();
  void draw_features();
  void sort_by(std::uint32_t feature, const Part& part);
  [[nodiscard]] Split best_split_of(std::uint32_t feature, const Part& part) const;
  [[nodiscard]] Split best_split(const Part& part);
  // Another node for a side of a split that is large enough, else a leaf; the child's number, where
  // leaves are counted from the number of samples on.
  std::uint32_t add_child(Part side, const Part& other);

  const TreeSamples& samples_;
  std::size_t least_leaf_rows_;
  std::size_t features_per_node_;
  dlib::rand random_;
  RankedColumns ranks_;
  std::vector<double> inverse_;  // of 1, 2, 3, ...
  std::vector<KeyedRow> rows_;   // of the bootstrap sample
  std::vector<KeyedRow> scratch_;
  std::vector<std::uint32_t> features_;
  std::vector<Part> open_;  // nodes that still have to be split, the next one last
  GrownTree tree_;
};

TreeGrower::TreeGrower(const TreeSamples& samples, const TreeOptions& options, std::uint64_t seed)
    : samples_(samples),
      least_leaf_rows_(options.least_leaf_rows),
      features_per_node_(static_cast<std::size_t>(std::max(
          1.0, std::round(static_cast<double>(samples.feature_count) * options.feature_share)))),
      random_(std::to_string(seed) + "/0"),
      ranks_(samples.rows, samples.feature_count),
      inverse_(samples.rows.size() + 1, 0.0),
      rows_(samples.rows.size()),
      scratch_(samples.rows.size()) {
  for (std::size_t i = 1; i < inverse_.size(); ++i) inverse_[i] = 1.0 / static_cast<double>(i);
}

Part TreeGrower::draw_bootstrap() {
  Part all{0.0, 0, rows_.size(), 0};
  for (KeyedRow& row : rows_) {
    row = keyed_row(0, static_cast<std::uint32_t>(
                           random_.get_integer(static_cast<long long>(samples_.labels.size()))));
    all.label_sum += samples_.labels[row_of(row)];
  }
  return all;
}

void TreeGrower::draw_features() {
  features_.resize(samples_.feature_count);
  std::iota(features_.begin(), features_.end(), 0U);
  const std::size_t count = std::min(features_per_node_, features_.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto other = random_.get_integer_in_range(static_cast<long long>(i),
                                                    static_cast<long long>(features_.size()));
    std::swap(features_[i], features_[static_cast<std::size_t>(other)]);
  }
  features_.resize(count);
}

void TreeGrower::sort_by(std::uint32_t feature, const Part& part) {
  const std::uint32_t* ranks = ranks_.column(feature);
  const std::span<KeyedRow> rows = std::span(rows_).subspan(part.begin, part.size());
  for (KeyedRow& row : rows) row = keyed_row(ranks[row_of(row)], row_of(row));
  sort_keyed_rows(rows, std::span(scratch_).first(part.size()), ranks_.bits(feature));
}

// Of the rows as they are sorted now.
Split TreeGrower::best_split_of(std::uint32_t feature, const Part& part) const {
  Split best{-1.0, samples_.labels[row_of(rows_[part.begin])], part.begin + 1, feature};
  if (key_of(rows_[part.begin]) == key_of(rows_[part.end - 1])) return best;  // nothing to split
  double left_sum = 0.0;
  for (std::size_t i = part.begin; i + 1 < part.end; ++i) {
    left_sum += samples_.labels[row_of(rows_[i])];
    if (key_of(rows_[i]) == key_of(rows_[i + 1])) continue;
    const double right_sum = part.label_sum - left_sum;
    const std::size_t left_size = i + 1 - part.begin;
    const std::size_t right_size = part.end - (i + 1);
    // A product instead of a division is off by a few units of the last place: it tells most
    // candidates that are not better, and the division decides the rest.
    constexpr double kSlack = 1.0 + 1e-12;
    const double left_square = left_sum * left_sum;
    const double right_square = right_sum * right_sum;
    const double near = left_square * inverse_[left_size] + right_square * inverse_[right_size];
    if (near * kSlack <= best.score) continue;
    const double score = left_square / static_cast<double>(left_size) +
                         right_square / static_cast<double>(right_size);
    if (score > best.score) best = {score, left_sum, i + 1, feature};
  }
  return best;
}

// Leaves the rows sorted by the feature of the split.
Split TreeGrower::best_split(const Part& part) {
  Split best;
  for (const std::uint32_t feature : features_) {
    // From one feature to the next, since the order of equal values decides how sums are rounded.
    sort_by(feature, part);
    const Split found = best_split_of(feature, part);
    if (best.score < found.score) best = found;
  }
  sort_by(best.feature, part);
  return best;
}

std::uint32_t TreeGrower::add_child(Part side, const Part& other) {
  if (side.size() > least_leaf_rows_ && other.size() != 0) {
    side.node = static_cast<std::uint32_t>(tree_.nodes.size());
    tree_.nodes.emplace_back();
    open_.push_back(side);
    return side.node;
  }
  tree_.leaf_values.push_back(side.mean());
  return static_cast<std::uint32_t>(samples_.labels.size() + tree_.leaf_values.size() - 1);
}

GrownTree TreeGrower::grow() {
  const std::vector<double>& labels = samples_.labels;
  if (labels.size() <= least_leaf_rows_) {
    const double sum = std::accumulate(labels.begin(), labels.end(), 0.0);
    tree_.leaf_values.push_back(static_cast<float>(sum / static_cast<double>(labels.size())));
    return std::move(tree_);
  }
  open_.push_back(draw_bootstrap());
  tree_.nodes.emplace_back();
  while (!open_.empty()) {
    const Part part = open_.back();
    open_.pop_back();
    draw_features();
    const Split split = best_split(part);
    const auto value = [&](std::size_t i) {
      return samples_.rows[row_of(rows_[i])][split.feature];
    };
    const Part left{split.left_sum, part.begin, split.at, 0};
    const Part right{part.label_sum - split.left_sum, split.at, part.end, 0};
    const float threshold = (value(split.at - 1) + value(split.at)) / 2;
    const std::uint32_t left_child = add_child(left, right);
    const std::uint32_t right_child = add_child(right, left);
    tree_.nodes[part.node] = {split.feature, threshold, left_child, right_child};
  }
  // Leaves were counted from the number of samples on, when the number of nodes was not known.
  const auto excess = static_cast<std::uint32_t>(labels.size() - tree_.nodes.size());
  for (TreeNode& node : tree_.nodes) {
    if (node.left >= labels.size()) node.left -= excess;
    if (node.right >= labels.size()) node.right -= excess;
  }
  return std::move(tree_);
}

}  // namespace

GrownTree grow_tree(const TreeSamples& samples, const TreeOptions& options, std::uint64_t seed) {
  return TreeGrower(samples, options, seed).grow();
}

}  // namespace sightline
