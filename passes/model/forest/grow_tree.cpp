#include "passes/model/forest/grow_tree.h"

#include <dlib/rand.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "passes/model/forest/tree_rows.h"

// dlib sorts the samples of a node by each feature that it tries. Here samples are put in order
// once for a whole forest, and each split keeps that order. Which of the samples with equal values
// comes first then differs, and with it how sums of labels are rounded: so they must be exact.

namespace sightline {
namespace {

constexpr std::uint32_t kNone = TreeRows::kNone;

// Rows of a node: places [begin, end) in the orders.
struct Part {
  double label_sum = 0.0;
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size = 0;    // of samples, with all copies
  std::uint32_t sure = 0;  // a feature in whose order they stand there for certain
  std::uint32_t node = 0;

  [[nodiscard]] float mean() const {
    return static_cast<float>(label_sum / static_cast<double>(size));
  }
};

struct Split {
  double score = -1.0;  // below that of any
  double left_sum = 0.0;
  std::size_t left_size = 0;
  std::size_t at = 0;  // where the right side begins
  std::uint32_t feature = kNone;
};

class TreeGrower {
 public:
  TreeGrower(const TreeSamples& samples, const RankedColumns& ranks, const TreeOptions& options,
             std::uint64_t seed);
  GrownTree grow();

 private:
  [[nodiscard]] std::vector<std::uint32_t> draw_bootstrap();
  void draw_features();
  void find_split(std::uint32_t feature, const Part& part, Split& best) const;
  void set_sides(const Part& part, const Split& split);
  [[nodiscard]] std::uint32_t first_row(const Part& part) const;
  [[nodiscard]] Split split_off_one(const Part& part);
  void split_node(const Part& part);
  [[nodiscard]] bool is_open(const Part& side) const { return side.size > least_leaf_rows_; }
  // Another node for a side of a split that is large enough, else a leaf; the child's number, where
  // leaves are counted from the number of samples on.
  std::uint32_t add_child(Part side, std::uint32_t parent);

  [[nodiscard]] float value(std::uint32_t feature, std::uint32_t row) const {
    return samples_.rows[rows_.sample_of(row)][feature];
  }

  const TreeSamples& samples_;
  std::size_t least_leaf_rows_;
  std::size_t features_per_node_;
  dlib::rand random_;
  TreeRows rows_;
  std::vector<double> inverse_;          // of 1, 2, 3, ...
  std::vector<std::uint32_t> shuffled_;  // features
  std::vector<std::uint32_t>
      sorted_by_;                       // [node]: features that were tried, then that of its split
  std::vector<std::uint32_t> parents_;  // [node]
  std::vector<Part> open_;              // nodes that still have to be split, the next one last
  GrownTree tree_;
};

TreeGrower::TreeGrower(const TreeSamples& samples, const RankedColumns& ranks,
                       const TreeOptions& options, std::uint64_t seed)
    : samples_(samples),
      least_leaf_rows_(options.least_leaf_rows),
      features_per_node_(std::min(samples.feature_count,
                                  static_cast<std::size_t>(std::max(
                                      1.0, std::round(static_cast<double>(samples.feature_count) *
                                                      options.feature_share))))),
      random_(std::to_string(seed) + "/0"),
      rows_(ranks, samples.labels, draw_bootstrap()),
      inverse_(samples.rows.size() + 1, 0.0),
      shuffled_(samples.feature_count) {
  for (std::size_t i = 1; i < inverse_.size(); ++i) inverse_[i] = 1.0 / static_cast<double>(i);
}

std::vector<std::uint32_t> TreeGrower::draw_bootstrap() {
  std::vector<std::uint32_t> draws(samples_.labels.size());
  for (std::uint32_t& sample : draws) {
    sample = static_cast<std::uint32_t>(
        random_.get_integer(static_cast<long long>(samples_.labels.size())));
  }
  return draws;
}

// Those of the next node that is split, in front.
void TreeGrower::draw_features() {
  std::iota(shuffled_.begin(), shuffled_.end(), 0U);
  for (std::size_t i = 0; i < features_per_node_; ++i) {
    const auto other = random_.get_integer_in_range(static_cast<long long>(i),
                                                    static_cast<long long>(shuffled_.size()));
    std::swap(shuffled_[i], shuffled_[static_cast<std::size_t>(other)]);
  }
}

// Puts a better one in the place of `best`.
void TreeGrower::find_split(std::uint32_t feature, const Part& part, Split& best) const {
  const std::uint32_t* rows = rows_.order(feature);
  const std::uint32_t* rank_of = rows_.ranks(feature);
  std::uint32_t rank = rank_of[rows[part.begin]];
  if (rank == rank_of[rows[part.end - 1]]) return;  // nothing to split
  double left_sum = 0.0;
  std::size_t left_size = 0;
  for (std::size_t i = part.begin; i + 1 < part.end; ++i) {
    const TreeRows::Copies& copies = rows_.copies(rows[i]);
    left_sum += copies.label_sum;
    left_size += copies.count;
    const std::uint32_t next_rank = rank_of[rows[i + 1]];
    if (std::exchange(rank, next_rank) == next_rank) continue;
    const double right_sum = part.label_sum - left_sum;
    const std::size_t right_size = part.size - left_size;
    // A product instead of a division is off by a few units of the last place: it tells most
    // candidates that are not better, and the division decides the rest.
    constexpr double kSlack = 1.0 + 1e-12;
    const double left_square = left_sum * left_sum;
    const double right_square = right_sum * right_sum;
    const double near = left_square * inverse_[left_size] + right_square * inverse_[right_size];
    if (near * kSlack <= best.score) continue;
    const double score = left_square / static_cast<double>(left_size) +
                         right_square / static_cast<double>(right_size);
    if (score > best.score) best = {score, left_sum, left_size, i + 1, feature};
  }
}

void TreeGrower::set_sides(const Part& part, const Split& split) {
  const std::uint32_t* rows = rows_.order(split.feature);
  for (std::size_t i = part.begin; i < part.end; ++i) rows_.set_side(rows[i], i >= split.at);
}

// The row that dlib has first where no feature that was tried tells any apart: it keeps the order
// of equal values from one sort to the next.
std::uint32_t TreeGrower::first_row(const Part& part) const {
  const std::uint32_t* all = rows_.order(part.sure);
  std::vector<std::uint32_t> rows(all + part.begin, all + part.end);
  const std::size_t per_node = features_per_node_ + 1;
  for (std::uint32_t node = parents_[part.node]; node != kNone; node = parents_[node]) {
    for (std::size_t i = per_node; i-- > 0 && rows.size() > 1;) {
      const std::uint32_t* rank_of = rows_.ranks(sorted_by_[node * per_node + i]);
      std::uint32_t least = kNone;
      for (const std::uint32_t row : rows) least = std::min(least, rank_of[row]);
      std::erase_if(rows, [&](std::uint32_t row) { return rank_of[row] != least; });
    }
  }
  return *std::ranges::min_element(rows, {},
                                   [&](std::uint32_t row) { return rows_.first_draw(row); });
}

// As dlib does where nothing can be split: the first sample becomes a leaf.
Split TreeGrower::split_off_one(const Part& part) {
  const std::uint32_t row = first_row(part);
  const double label = rows_.take_copy(row);
  const bool is_gone = rows_.copies(row).count == 0;
  const std::uint32_t* rows = rows_.order(part.sure);
  for (std::size_t i = part.begin; i < part.end; ++i) {
    rows_.set_side(rows[i], rows[i] != row || !is_gone);
  }
  return {-1.0, label, 1, part.begin + (is_gone ? 1 : 0), shuffled_.front()};
}

void TreeGrower::split_node(const Part& part) {
  draw_features();
  Split split;
  for (std::size_t i = 0; i < features_per_node_; ++i) find_split(shuffled_[i], part, split);
  const bool is_split = split.feature != kNone;
  if (is_split) {
    set_sides(part, split);
  } else {
    split = split_off_one(part);
  }
  const std::size_t place = part.node * (features_per_node_ + 1);
  sorted_by_.resize(std::max(sorted_by_.size(), place + features_per_node_ + 1));
  std::copy_n(shuffled_.begin(), features_per_node_,
              sorted_by_.begin() + static_cast<std::ptrdiff_t>(place));
  sorted_by_[place + features_per_node_] = split.feature;
  const std::uint32_t sure = is_split ? split.feature : part.sure;
  const std::uint32_t* rows = rows_.order(sure);
  const float low = value(split.feature, rows[is_split ? split.at - 1 : part.begin]);
  const float high = value(split.feature, rows[is_split ? split.at : part.begin]);
  const Part left{split.left_sum, part.begin, split.at, split.left_size, sure, 0};
  const Part right{part.label_sum - split.left_sum, split.at, part.end,
                   part.size - split.left_size,     sure,     0};
  if (is_open(left) || is_open(right)) rows_.part(part.begin, part.end, sure);
  const std::uint32_t left_child = add_child(left, part.node);
  const std::uint32_t right_child = add_child(right, part.node);
  tree_.nodes[part.node] = {split.feature, (low + high) / 2, left_child, right_child};
}

std::uint32_t TreeGrower::add_child(Part side, std::uint32_t parent) {
  if (is_open(side)) {
    side.node = static_cast<std::uint32_t>(tree_.nodes.size());
    tree_.nodes.emplace_back();
    parents_.push_back(parent);
    open_.push_back(side);
    return side.node;
  }
  tree_.leaf_values.push_back(side.mean());
  return static_cast<std::uint32_t>(samples_.labels.size() + tree_.leaf_values.size() - 1);
}

GrownTree TreeGrower::grow() {
  const std::vector<double>& labels = samples_.labels;
  const double sum = std::accumulate(labels.begin(), labels.end(), 0.0);
  if (labels.size() <= least_leaf_rows_) {
    tree_.leaf_values.push_back(static_cast<float>(sum / static_cast<double>(labels.size())));
    return std::move(tree_);
  }
  Part all{0.0, 0, rows_.size(), labels.size(), 0, 0};
  for (std::uint32_t row = 0; row < rows_.size(); ++row) {
    all.label_sum += rows_.copies(row).label_sum;
  }
  tree_.nodes.emplace_back();
  parents_.push_back(kNone);
  open_.push_back(all);
  while (!open_.empty()) {
    const Part part = open_.back();
    open_.pop_back();
    split_node(part);
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

double summable_label(double label) { return std::nearbyint(label * 0x1.0p30) * 0x1.0p-30; }

GrownTree grow_tree(const TreeSamples& samples, const RankedColumns& ranks,
                    const TreeOptions& options, std::uint64_t seed) {
  return TreeGrower(samples, ranks, options, seed).grow();
}

}  // namespace sightline
