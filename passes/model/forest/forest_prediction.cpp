#include "passes/model/forest/forest_prediction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

// Rows of one block go down a tree before the next tree is touched, so that a tree stays in the
// processor's nearest cache.
constexpr std::size_t kRowsPerBlock = 512;

std::vector<double> answers_of(const std::vector<std::uint32_t>& leaf_of_label,
                               std::size_t leaf_count, const std::vector<double>& labels,
                               const std::vector<double>& limits) {
  const std::size_t answer_count = 1 + limits.size();
  std::vector<double> answers(leaf_count * answer_count, 0.0);
  std::vector<double> label_count(leaf_count, 0.0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    double* answer = &answers[leaf_of_label[i] * answer_count];
    label_count[leaf_of_label[i]] += 1.0;
    answer[0] += labels[i];
    for (std::size_t limit = 0; limit < limits.size(); ++limit) {
      if (labels[i] <= limits[limit]) answer[1 + limit] += 1.0;
    }
  }
  for (std::size_t i = 0; i < answers.size(); ++i) answers[i] /= label_count[i / answer_count];
  return answers;
}

// A leaf's number, from the node `at` on.
std::uint32_t leaf_from(const std::vector<TreeNode>& nodes, std::uint32_t at, const float* row) {
  while (at < nodes.size()) {
    at = row[nodes[at].feature] < nodes[at].threshold ? nodes[at].left : nodes[at].right;
  }
  return at - static_cast<std::uint32_t>(nodes.size());
}

// A feature whose other value leads to another leaf.
struct Parting {
  std::uint32_t feature;
  std::uint32_t leaf;
};

// The leaf of the row, and where each feature would lead alone: its way parts from the row's at the
// first split that it decides otherwise.
std::uint32_t leaf_and_partings(const std::vector<TreeNode>& nodes, float* row, const float* others,
                                std::vector<std::uint8_t>& has_parted,
                                std::vector<Parting>& partings) {
  partings.clear();
  std::uint32_t at = 0;
  while (at < nodes.size()) {
    const TreeNode& node = nodes[at];
    const bool goes_left = row[node.feature] < node.threshold;
    const bool other_goes_left = others[node.feature] < node.threshold;
    if (goes_left != other_goes_left && has_parted[node.feature] == 0) {
      has_parted[node.feature] = 1;
      const float own = std::exchange(row[node.feature], others[node.feature]);
      const std::uint32_t side = other_goes_left ? node.left : node.right;
      partings.push_back({node.feature, leaf_from(nodes, side, row)});
      row[node.feature] = own;
    }
    at = goes_left ? node.left : node.right;
  }
  for (const Parting& parting : partings) has_parted[parting.feature] = 0;
  return at - static_cast<std::uint32_t>(nodes.size());
}

constexpr double kSaturated = 0.005;
constexpr double kPriorPairs = 20.0;
constexpr int kMostSteps = 50;
constexpr double kStepIsSmall = 1e-10;
constexpr double kLongestStep = 0.5;  // where the likelihood is flat Newton leaps out of sight

double log_odds(double share) { return portable_log(share / (1.0 - share)); }

double from_log_odds(double odds) { return 1.0 / (1.0 + portable_exp(-odds)); }

// Terms of the likelihood's gradient and Hessian, summed over the pairs.
struct NewtonSums {
  double gradient_offset = 0.0;
  double gradient_slope = 0.0;
  double offset_offset = 0.0;
  double offset_slope = 0.0;
  double slope_slope = 0.0;
};

NewtonSums sums_at(const ProbabilityCurve& curve, const std::vector<double>& odds,
                   const std::vector<double>& met) {
  const std::size_t count = odds.size();
  std::vector<double> residual(count), weight(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double p = from_log_odds(curve.offset + curve.slope * odds[i]);
    residual[i] = met[i] - p;
    weight[i] = p * (1.0 - p);
  }
  const auto sum = [&](const auto& term) {
    std::vector<double> terms(count);
    for (std::size_t i = 0; i < count; ++i) terms[i] = term(i);
    return ordered_sum(terms);
  };
  NewtonSums sums;
  sums.gradient_offset = ordered_sum(residual) - kPriorPairs * curve.offset;
  sums.gradient_slope =
      sum([&](std::size_t i) { return residual[i] * odds[i]; }) - kPriorPairs * (curve.slope - 1.0);
  sums.offset_offset = ordered_sum(weight) + kPriorPairs;
  sums.offset_slope = sum([&](std::size_t i) { return weight[i] * odds[i]; });
  sums.slope_slope =
      sum([&](std::size_t i) { return weight[i] * odds[i] * odds[i]; }) + kPriorPairs;
  return sums;
}

// `labels_m`: [site][look].
template <class Label>
PredictedShares shares_of(const TrainingSet& training_set, const std::vector<Label>& labels_m,
                          const std::vector<double>& within, const std::vector<double>& limits_m) {
  PredictedShares shares;
  for (std::size_t row = 0; row < labels_m.size(); ++row) {
    if (training_set.sites[training_set.shape().site_of(row)].has_label == 0) continue;
    for (std::size_t limit = 0; limit < limits_m.size(); ++limit) {
      shares.share.push_back(within[row * limits_m.size() + limit]);
      shares.is_met.push_back(double{labels_m[row]} <= limits_m[limit] ? 1 : 0);
    }
  }
  return shares;
}

}  // namespace

PreparedForest::PreparedForest(const RegressionForest& forest, const std::vector<double>& limits,
                               int threads)
    : PreparedForest(LabelledTrees{training_rows(forest), forest.labels, forest.trees}, limits,
                     threads) {}

PreparedForest::PreparedForest(LabelledTrees forest, const std::vector<double>& limits, int threads)
    : trees_(forest.trees.size()), answer_count_(1 + limits.size()) {
  parallel_for(trees_.size(), threads, [&](std::size_t t) {
    std::vector<TreeNode>& nodes = forest.trees[t].nodes;
    std::vector<std::uint32_t> leaves(forest.rows.size());
    find_leaves(nodes, forest.rows, leaves);
    trees_[t].answers = answers_of(leaves, nodes.size() + 1, forest.labels, limits);
    trees_[t].nodes = std::move(nodes);
  });
}

void PreparedForest::add_answers(const Tree& tree, const std::vector<const float*>& rows,
                                 std::vector<std::uint32_t>& leaves,
                                 std::vector<double>& sums) const {
  find_leaves(tree.nodes, rows, leaves);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double* answer = &tree.answers[leaves[i] * answer_count_];
    double* sum = &sums[i * answer_count_];
    for (std::size_t k = 0; k < answer_count_; ++k) sum[k] += answer[k];
  }
}

ForestPrediction PreparedForest::predict(const FeatureRows& features,
                                         const std::vector<std::uint32_t>& rows,
                                         int threads) const {
  const std::size_t limit_count = answer_count_ - 1;
  const auto tree_count = static_cast<double>(trees_.size());
  ForestPrediction prediction;
  prediction.mean.resize(rows.size());
  prediction.within.resize(rows.size() * limit_count);
  const auto predict_block = [&](std::size_t block) {
    const std::size_t first = block * kRowsPerBlock;
    const std::size_t last = std::min(first + kRowsPerBlock, rows.size());
    std::vector<const float*> inputs;
    for (std::size_t i = first; i < last; ++i) inputs.push_back(features.row(rows[i]));
    std::vector<std::uint32_t> leaves(inputs.size());
    std::vector<double> sums(inputs.size() * answer_count_, 0.0);
    for (const Tree& tree : trees_) add_answers(tree, inputs, leaves, sums);
    for (std::size_t i = first; i < last; ++i) {
      const double* sum = &sums[(i - first) * answer_count_];
      prediction.mean[i] = sum[0] / tree_count;
      for (std::size_t limit = 0; limit < limit_count; ++limit) {
        prediction.within[i * limit_count + limit] = sum[1 + limit] / tree_count;
      }
    }
  };
  parallel_for((rows.size() + kRowsPerBlock - 1) / kRowsPerBlock, threads, predict_block);
  return prediction;
}

std::vector<double> PreparedForest::means_with_others(const FeatureRows& features,
                                                      const std::vector<std::uint32_t>& rows,
                                                      const std::vector<float>& others,
                                                      int threads) const {
  constexpr std::size_t kRowsWithOthers = 32;  // whose sums stay in the nearest caches
  const std::size_t feature_count = features.names.size();
  const auto tree_count = static_cast<double>(trees_.size());
  std::vector<double> sums(rows.size() * feature_count, 0.0);
  const auto add_block = [&](std::size_t block) {
    const std::size_t first = block * kRowsWithOthers;
    const std::size_t last = std::min(first + kRowsWithOthers, rows.size());
    std::vector<float> own;  // rows of which single values are exchanged
    for (std::size_t i = first; i < last; ++i) {
      own.insert(own.end(), features.row(rows[i]), features.row(rows[i]) + feature_count);
    }
    std::vector<std::uint8_t> has_parted(feature_count, 0);
    std::vector<Parting> partings;
    std::vector<double> parted_sums;
    for (const Tree& tree : trees_) {
      for (std::size_t i = first; i < last; ++i) {
        double* sum = &sums[i * feature_count];
        const std::uint32_t leaf =
            leaf_and_partings(tree.nodes, &own[(i - first) * feature_count],
                              &others[i * feature_count], has_parted, partings);
        // Added tree by tree, as predict() adds.
        parted_sums.clear();
        for (const Parting& parting : partings) {
          parted_sums.push_back(sum[parting.feature] + tree.answers[parting.leaf * answer_count_]);
        }
        const double answer = tree.answers[leaf * answer_count_];
        for (std::size_t f = 0; f < feature_count; ++f) sum[f] += answer;
        for (std::size_t k = 0; k < partings.size(); ++k) sum[partings[k].feature] = parted_sums[k];
      }
    }
    for (std::size_t i = first * feature_count; i < last * feature_count; ++i)
      sums[i] /= tree_count;
  };
  parallel_for((rows.size() + kRowsWithOthers - 1) / kRowsWithOthers, threads, add_block);
  return sums;
}

double on_curve(const ProbabilityCurve& curve, double share) {
  const bool is_identity = curve.offset == 0.0 && curve.slope == 1.0;
  if (share <= 0.0 || share >= 1.0 || is_identity) return share;
  return from_log_odds(curve.offset + curve.slope * log_odds(share));
}

ProbabilityCurve fit_curve(const PredictedShares& shares) {
  std::vector<double> odds, met;
  for (std::size_t i = 0; i < shares.share.size(); ++i) {
    if (shares.share[i] < kSaturated || shares.share[i] > 1.0 - kSaturated) continue;
    odds.push_back(log_odds(shares.share[i]));
    met.push_back(shares.is_met[i]);
  }
  ProbabilityCurve curve;
  bool has_converged = false;
  for (int step = 0; step < kMostSteps && !has_converged; ++step) {
    const NewtonSums sums = sums_at(curve, odds, met);
    // Above 0: the prior alone makes it so.
    const double determinant =
        sums.offset_offset * sums.slope_slope - sums.offset_slope * sums.offset_slope;
    const double offset_step =
        (sums.slope_slope * sums.gradient_offset - sums.offset_slope * sums.gradient_slope) /
        determinant;
    const double slope_step =
        (sums.offset_offset * sums.gradient_slope - sums.offset_slope * sums.gradient_offset) /
        determinant;
    curve.offset += std::clamp(offset_step, -kLongestStep, kLongestStep);
    curve.slope += std::clamp(slope_step, -kLongestStep, kLongestStep);
    has_converged = std::abs(offset_step) + std::abs(slope_step) < kStepIsSmall;
  }
  return has_converged && curve.slope > 0.0 ? curve : ProbabilityCurve{};
}

PredictedShares predicted_shares(const TrainingSet& training_set, const PredictedError& predicted) {
  return shares_of(training_set, training_set.labels, predicted.within_probability,
                   predicted.limits_m);
}

PredictedShares predicted_tracking_shares(const TrainingSet& training_set,
                                          const std::vector<double>& within,
                                          const std::vector<double>& limits_m) {
  return shares_of(training_set, training_set.tracking_labels_m, within, limits_m);
}

void put_on_curve(const ProbabilityCurve& curve, PredictedError& predicted) {
  for (double& share : predicted.within_probability) share = on_curve(curve, share);
}

Support::Support(const ErrorModel& model, double margin) : model_(model), margin_(margin) {
  for (const FeatureCard& feature : model.features) {
    const bool is_range = &feature == &model.features.back();
    weights_.push_back(is_range ? 0.0 : std::max(0.0, feature.importance_m));
  }
  const double total = ordered_sum(weights_);
  if (total <= 0.0) return;
  for (double& weight : weights_) weight /= total;
}

double Support::outside_share(const float* row, std::size_t range) const {
  double share = 0.0;
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const double least = model_.features[i].support_min[range];
    const double greatest = model_.features[i].support_max[range];
    const double slack = margin_ * (greatest - least);
    const double value = row[i];
    if (value < least - slack || value > greatest + slack) share += weights_[i];
  }
  return share;
}

bool Support::is_outside(const float* row, std::size_t range) const {
  constexpr double kMostOutside = 0.5;
  return outside_share(row, range) > kMostOutside;
}

}  // namespace sightline
