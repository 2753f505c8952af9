#include "passes/model/forest/growing/grow_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "passes/model/forest/growing/best_split.h"
#include "passes/model/forest/growing/tree_rows.h"

// dlib sorts the samples of a node by each feature that it tries. Here samples are put in order
// once for a whole forest, and each split keeps that order. Which of the samples with equal values
// comes first then differs, and with it how sums of labels are rounded: so they must be exact.

namespace sightline {
namespace {

constexpr std::uint32_t kNone = TreeRows::kNone;

class TreeGrower {
 public:
  TreeGrower(const TreeSamples& samples, const RankedColumns& ranks, const TreeOptions& options,
             std::uint64_t seed);
  GrownTree grow();

 private:
  [[nodiscard]] std::vector<std::uint32_t> draw_bootstrap();
  void draw_features();
  void set_sides(const Part& part, const Split& split);
  [[nodiscard]] std::uint32_t first_row(const Part& part) const;
  [[nodiscard]] Split split_off_one(const Part& part);
  void split_node(const Part& part);
  [[nodiscard]] bool is_open(const Part& side) const { return side.size > least_leaf_rows_; }
  // Another node for a side of a split that is large enough, else a leaf; the child's number, where
  // leaves are counted from the number of samples on.
  std::uint32_t add_child(Part side, std::uint32_t parent);
  void set_thresholds();

  [[nodiscard]] float value(std::uint32_t feature, std::uint32_t row) const {
    return samples_.rows[rows_.sample_of(row)][feature];
  }

  const TreeSamples& samples_;
  std::size_t least_leaf_rows_;
  std::size_t features_per_node_;
  TreeRandom random_;
  TreeRows rows_;
  std::vector<std::uint32_t> shuffled_;  // features
  std::vector<std::uint32_t>
      sorted_by_;                       // [node]: features that were tried, then that of its split
  std::vector<std::uint32_t> parents_;  // [node]
  // [node]: the rows next to its split.
  struct Edges {
    std::uint32_t low = 0;
    std::uint32_t high = 0;
  };
  std::vector<Edges> edges_;
  std::vector<Part> open_;  // nodes that still have to be split, the next one last
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
      random_(seed),
      rows_(ranks, samples.labels, draw_bootstrap()),
      shuffled_(samples.feature_count) {}

std::vector<std::uint32_t> TreeGrower::draw_bootstrap() {
  std::vector<std::uint32_t> draws(samples_.labels.size());
  for (std::uint32_t& sample : draws) {
    sample = static_cast<std::uint32_t>(random_.in_range(0, samples_.labels.size()));
  }
  return draws;
}

// Those of the next node that is split, in front.
void TreeGrower::draw_features() {
  std::iota(shuffled_.begin(), shuffled_.end(), 0U);
  for (std::size_t i = 0; i < features_per_node_; ++i) {
    std::swap(shuffled_[i], shuffled_[random_.in_range(i, shuffled_.size())]);
  }
}

void TreeGrower::set_sides(const Part& part, const Split& split) {
  const std::uint32_t* rows = rows_.order(split.feature);
  for (std::size_t i = part.begin; i < part.end; ++i) rows_.set_side(rows[i], i >= split.at);
}

// The row that dlib has first where no feature that was tried distinguishes any: it keeps the order
// of equal values from one sort to the next.
std::uint32_t TreeGrower::first_row(const Part& part) const {
  const std::uint32_t* all = rows_.order(part.sure);
  std::vector<std::uint32_t> rows(all + part.begin, all + part.end);
  const std::size_t per_node = features_per_node_ + 1;
  for (std::uint32_t node = parents_[part.node]; node != kNone; node = parents_[node]) {
    for (std::size_t i = per_node; i-- > 0 && rows.size() > 1;) {
      const TreeRows::Ranks rank_of = rows_.ranks(sorted_by_[node * per_node + i]);
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
  const bool is_gone = rows_.copies(row).count() == 0.0;
  const std::uint32_t* rows = rows_.order(part.sure);
  for (std::size_t i = part.begin; i < part.end; ++i) {
    rows_.set_side(rows[i], rows[i] != row || !is_gone);
  }
  return {-1.0, label, 1, part.begin + (is_gone ? 1 : 0), shuffled_.front()};
}

void TreeGrower::split_node(const Part& part) {
  draw_features();
  Split split = best_split(rows_, part, std::span(shuffled_).first(features_per_node_));
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
  edges_.resize(tree_.nodes.size());
  edges_[part.node] = {rows[is_split ? split.at - 1 : part.begin],
                       rows[is_split ? split.at : part.begin]};
  const Part left{split.left_sum, part.begin, split.at, split.left_size, sure, 0};
  const Part right{part.label_sum - split.left_sum, split.at, part.end,
                   part.size - split.left_size,     sure,     0};
  if (is_open(left) || is_open(right)) {
    rows_.part({part.begin, split.at, part.end, is_open(left), is_open(right)}, sure);
  }
  const std::uint32_t left_child = add_child(left, part.node);
  const std::uint32_t right_child = add_child(right, part.node);
  tree_.nodes[part.node] = {split.feature, 0.0F, left_child, right_child};
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

// All at once: values lie far apart in memory, and the processor can ask for many.
void TreeGrower::set_thresholds() {
  for (std::size_t i = 0; i < tree_.nodes.size(); ++i) {
    TreeNode& node = tree_.nodes[i];
    node.threshold = (value(node.feature, edges_[i].low) + value(node.feature, edges_[i].high)) / 2;
  }
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
    all.label_sum += rows_.copies(row).label_sum();
  }
  tree_.nodes.emplace_back();
  parents_.push_back(kNone);
  open_.push_back(all);
  while (!open_.empty()) {
    const Part part = open_.back();
    open_.pop_back();
    split_node(part);
  }
  set_thresholds();
  // Leaves were counted from the number of samples on, when the number of nodes was not known.
  const auto excess = static_cast<std::uint32_t>(labels.size() - tree_.nodes.size());
  for (TreeNode& node : tree_.nodes) {
    if (node.left >= labels.size()) node.left -= excess;
    if (node.right >= labels.size()) node.right -= excess;
  }
  return std::move(tree_);
}

// dlib lets this many numbers pass after seeding.
constexpr unsigned long long kDiscarded = 10'000;

std::uint32_t engine_seed(const std::string& text) {
  std::uint32_t seed = 0;
  for (const char c : text) seed = seed * 37 + static_cast<std::uint32_t>(c);
  return seed;
}

std::uint64_t draw_64_bits(std::mt19937& engine) {
  const std::uint64_t high = engine();
  return high << 32 | engine();
}

}  // namespace

double summable_label(double label) { return std::nearbyint(label * 0x1.0p30) * 0x1.0p-30; }

GrownTree grow_tree(const TreeSamples& samples, const RankedColumns& ranks,
                    const TreeOptions& options, std::uint64_t seed) {
  return TreeGrower(samples, ranks, options, seed).grow();
}

TreeRandom::TreeRandom(std::uint64_t seed) : engine_(engine_seed(std::to_string(seed) + "/0")) {
  engine_.discard(kDiscarded);
}

std::size_t TreeRandom::in_range(std::size_t begin, std::size_t end) {
  if (begin == end) return begin;
  const std::uint64_t size = end - begin;
  // Numbers of the last, incomplete run of `size` numbers are rejected: the first ones would be
  // likelier.
  const std::uint64_t limit = std::numeric_limits<std::uint64_t>::max() / size * size;
  std::uint64_t number = draw_64_bits(engine_);
  while (number >= limit) number = draw_64_bits(engine_);
  return begin + number % size;
}

}  // namespace sightline
