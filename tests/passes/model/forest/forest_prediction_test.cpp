#include "passes/model/forest/forest_prediction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "formats/base/random.h"
#include "passes/model/forest/growing/grow_trees.h"
#include "tests/support/handmade_model.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

PredictedShares drawn_on(const ProbabilityCurve& curve, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  PredictedShares shares;
  for (std::size_t i = 0; i < count; ++i) {
    shares.share.push_back(random.uniform());
    shares.is_met.push_back(random.uniform() < on_curve(curve, shares.share.back()) ? 1 : 0);
  }
  return shares;
}

TEST(ProbabilityCurve, FindsTheCurveThatPairsWereDrawnOn) {
  for (const ProbabilityCurve& drawn : {ProbabilityCurve{-0.2, 1.2}, {0.3, 0.8}, {0.0, 1.0}}) {
    const ProbabilityCurve found = fit_curve(drawn_on(drawn, 40000, 1));
    EXPECT_NEAR(found.offset, drawn.offset, 0.04);
    EXPECT_NEAR(found.slope, drawn.slope, 0.04);
  }
}

TEST(ProbabilityCurve, ALargerShareIsNeverLessProbable) {
  const ProbabilityCurve curve{-0.2, 1.2};
  double before = 0.0;
  for (int i = 0; i <= 1000; ++i) {
    const double p = on_curve(curve, i / 1000.0);
    EXPECT_GE(p, before);
    before = p;
  }
  EXPECT_EQ(on_curve(curve, 0.0), 0.0);
  EXPECT_EQ(on_curve(curve, 1.0), 1.0);
}

TEST(ProbabilityCurve, StaysNearTheSharesWherePairsAreFew) {
  const ProbabilityCurve few = fit_curve(drawn_on({1.0, 2.0}, 10, 3));
  EXPECT_LT(std::abs(few.offset), 0.3);
  EXPECT_LT(std::abs(few.slope - 1.0), 0.3);
  const ProbabilityCurve none = fit_curve({});
  EXPECT_EQ(none.offset, 0.0);
  EXPECT_EQ(none.slope, 1.0);
}

TEST(ProbabilityCurve, BelievesTheSharesWhereLargerOnesComeTrueLessOften) {
  PredictedShares shares = drawn_on({}, 5000, 5);
  for (double& share : shares.share) share = 1.0 - share;
  const ProbabilityCurve curve = fit_curve(shares);
  EXPECT_EQ(curve.offset, 0.0);
  EXPECT_EQ(curve.slope, 1.0);
}

// Three features and the range, at one range; training saw 0 to 10 of each.
ErrorModel three_features(const std::vector<double>& importance_m) {
  ErrorModel model = handmade_model({{{0.9}, {0.05}}}, 1);
  model.features.clear();
  for (const double importance : importance_m) {
    model.features.push_back({"factor", importance, {0.0}, {10.0}});
  }
  model.features.push_back({"range_m", 5.0, {10.0}, {10.0}});
  return model;
}

TEST(Support, WeighsAFeatureByWhatTheForestMakesOfIt) {
  const ErrorModel model = three_features({0.03, 0.01, 0.0});
  const Support support(model, 0.25);
  const std::vector<float> inside = {12.4F, -2.4F, 5.0F, 10.0F};
  const std::vector<float> first = {12.6F, 5.0F, 5.0F, 10.0F};
  const std::vector<float> others = {5.0F, -2.6F, 1000.0F, 10.0F};
  EXPECT_EQ(support.outside_share(inside.data(), 0), 0.0);
  EXPECT_NEAR(support.outside_share(first.data(), 0), 0.75, 1e-12);
  EXPECT_NEAR(support.outside_share(others.data(), 0), 0.25, 1e-12);
  EXPECT_TRUE(support.is_outside(first.data(), 0));
  EXPECT_FALSE(support.is_outside(others.data(), 0)) << "counts that the forest hardly uses";
}

TEST(Support, IgnoresFeaturesThatHelpNothing) {
  const std::vector<float> far = {1e6F, 1e6F, 1e6F, 10.0F};
  const ErrorModel harmful = three_features({-0.02, 0.0, 0.01});
  EXPECT_NEAR(Support(harmful, 0.25).outside_share(far.data(), 0), 1.0, 1e-12);
  EXPECT_EQ(Support(three_features({-0.02, 0.0, 0.0}), 0.25).outside_share(far.data(), 0), 0.0);
}

TEST(Support, AWiderMarginNeverRefusesMore) {
  const ErrorModel model = three_features({0.03, 0.02, 0.01});
  for (float value = -40.0F; value < 50.0F; value += 1.7F) {
    const std::vector<float> row = {value, 0.5F * value, -value, 10.0F};
    double before = 1.0;
    for (const double margin : {0.0, 0.25, 1.0, 3.0}) {
      const double share = Support(model, margin).outside_share(row.data(), 0);
      EXPECT_LE(share, before);
      before = share;
    }
  }
}

struct Problem {
  FeatureRows features;
  LabelledRows training;
};

Problem random_problem(std::uint64_t seed, std::size_t row_count, std::size_t feature_count) {
  Random random(seed);
  Problem problem;
  problem.features.names.assign(feature_count, "factor");
  problem.features.row_count = row_count;
  for (std::uint32_t i = 0; i < row_count; ++i) {
    double label = 0.1 * random.uniform();
    for (std::size_t k = 0; k < feature_count; ++k) {
      problem.features.values.push_back(static_cast<float>(random.normal()));
      label += k < 2 ? std::abs(problem.features.values.back()) : 0.0;
    }
    problem.training.rows.push_back(i);
    problem.training.labels.push_back(label);
  }
  return problem;
}

// [label]: where its row falls, one row after another.
std::vector<std::uint32_t> leaves_of_labels(const RegressionForest& forest,
                                            const RegressionTree& tree) {
  std::vector<std::uint32_t> leaves;
  for (const float* row : training_rows(forest)) leaves.push_back(leaf_of(tree.nodes, row));
  return leaves;
}

double brute_force_within(const RegressionForest& forest, const float* row, double limit) {
  double sum = 0.0;
  for (const RegressionTree& tree : forest.trees) {
    const std::uint32_t leaf = leaf_of(tree.nodes, row);
    const std::vector<std::uint32_t> leaves = leaves_of_labels(forest, tree);
    double met = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < forest.labels.size(); ++i) {
      if (leaves[i] != leaf) continue;
      count += 1.0;
      met += forest.labels[i] <= limit ? 1.0 : 0.0;
    }
    sum += met / count;
  }
  return sum / static_cast<double>(forest.trees.size());
}

TEST(Forest, KeepsEachLabelInOneLeafOfEachTreeAndEnoughInEach) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Problem problem = random_problem(seed, 200, 4);
    const RegressionForest forest =
        value_of(grow_forest(problem.features, problem.training, {10, 5, 0.4}, seed, 1));
    require(validate(forest));
    const LabelledRows sorted = sorted_by_label(problem.training);
    for (const RegressionTree& tree : forest.trees) {
      std::map<std::uint32_t, int> rows_in_leaf;
      const std::vector<std::uint32_t> leaves = leaves_of_labels(forest, tree);
      for (const std::uint32_t leaf : leaves) ++rows_in_leaf[leaf];
      EXPECT_EQ(rows_in_leaf.size(), tree.leaf_count());
      for (const auto& [leaf, count] : rows_in_leaf) EXPECT_GE(count, 5);
      std::vector<std::uint32_t> found(leaves.size());
      find_leaves(tree.nodes, training_rows(forest), found);
      EXPECT_EQ(found, leaves);
    }
    for (std::size_t i = 0; i < sorted.rows.size(); ++i) {
      EXPECT_TRUE(std::equal(training_rows(forest)[i], training_rows(forest)[i] + 4,
                             problem.features.row(sorted.rows[i])));
    }
  }
}

TEST(Forest, TellsWhatOtherValuesOfOneFeatureWouldChange) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Problem problem = random_problem(seed, seed == 4 ? 6 : 300, 6);
    for (std::size_t i = 0; i < problem.features.row_count; ++i) problem.features.at(i, 5) = 1.0F;
    LabelledTrees trees =
        value_of(grow_labelled_trees(problem.features, problem.training, {20, 5, 0.4}, seed, 1));
    const PreparedForest forest(std::move(trees), {0.5}, 1);
    const std::vector<std::uint32_t> rows = {3, 1, 0, 5, 4, 2};
    Random random(seed);
    std::vector<float> others;
    for (std::size_t i = 0; i < rows.size() * 6; ++i) {
      others.push_back(static_cast<float>(random.normal()));
    }
    const std::vector<double> means = forest.means_with_others(problem.features, rows, others, 2);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t f = 0; f < 6; ++f) {
        FeatureRows changed = problem.features;
        changed.at(rows[i], f) = others[i * 6 + f];
        EXPECT_EQ(means[i * 6 + f], forest.predict(changed, {rows[i]}, 1).mean[0]) << seed;
      }
    }
  }
}

TEST(Forest, AnswersForAnyLimitFromItsLeafLabels) {
  const Problem problem = random_problem(5, 150, 3);
  const RegressionForest forest =
      value_of(grow_forest(problem.features, problem.training, {9, 5, 0.4}, 1, 1));
  const std::vector<double> limits = {0.2, 1.0, 1.7, 100.0};
  const ForestPrediction predicted =
      PreparedForest(forest, limits, 1).predict(problem.features, problem.training.rows, 1);
  for (std::size_t i = 0; i < 150; ++i) {
    for (std::size_t limit = 0; limit < limits.size(); ++limit) {
      EXPECT_NEAR(predicted.within[i * limits.size() + limit],
                  brute_force_within(forest, problem.features.row(i), limits[limit]), 1e-12);
    }
    EXPECT_EQ(predicted.within[i * limits.size() + 3], 1.0);
  }
}

TEST(Forest, IsTheSameForAnyThreadCount) {
  const Problem problem = random_problem(7, 700, 4);
  const auto bytes_with = [&](int threads) {
    const Result<RegressionForest> forest =
        grow_forest(problem.features, problem.training, {20, 5, 0.4}, 1, threads);
    ByteWriter writer;
    encode(*forest, writer);
    const ForestPrediction predicted =
        PreparedForest(*forest, {1.0}, threads)
            .predict(problem.features, problem.training.rows, threads);
    writer.put_array(predicted.mean);
    writer.put_array(predicted.within);
    return writer.take();
  };
  EXPECT_EQ(bytes_with(1), bytes_with(2));
}

TEST(Forest, GrowsATreeOnSomeRowsAndLabelsItWithAll) {
  const Problem problem = random_problem(3, 600, 4);
  ForestOptions options{10, 5, 0.4};
  options.tree_rows = 60;
  const RegressionForest forest =
      value_of(grow_forest(problem.features, problem.training, options, 1, 1));
  ASSERT_TRUE(validate(forest).has_value());
  EXPECT_EQ(forest.labels.size(), 600u);
  for (const RegressionTree& tree : forest.trees) {
    EXPECT_LE(tree.leaf_count(), 30u);  // of 600 rows it would have a hundred
    EXPECT_GE(tree.leaf_count(), 4u);
    EXPECT_EQ(leaves_of_labels(forest, tree).size(), 600u);
  }
  EXPECT_NE(forest.trees[0], forest.trees[1]);
}

TEST(Forest, LearnsAStepItCanSee) {
  Problem problem = random_problem(1, 200, 1);
  for (std::uint32_t i = 0; i < 200; ++i) {
    problem.training.labels[i] = problem.features.row(i)[0] < 0.0F ? 1.0 : 2.0;
  }
  const RegressionForest forest =
      value_of(grow_forest(problem.features, problem.training, {20, 5, 1.0}, 1, 1));
  FeatureRows asked;
  asked.names = {"factor"};
  asked.row_count = 2;
  asked.values = {-1.0F, 1.0F};
  const ForestPrediction predicted = PreparedForest(forest, {1.5}, 1).predict(asked, {0, 1}, 1);
  // A bootstrap sample may lack the rows next to the step.
  EXPECT_NEAR(predicted.mean[0], 1.0, 0.02);
  EXPECT_NEAR(predicted.mean[1], 2.0, 0.02);
  EXPECT_NEAR(predicted.within[0], 1.0, 0.02);
  EXPECT_NEAR(predicted.within[1], 0.0, 0.02);
}

TEST(Forest, TakesConstantFeaturesAndFewRows) {
  Problem problem = random_problem(1, 40, 2);
  std::fill(problem.features.values.begin(), problem.features.values.end(), 3.0F);
  for (const std::size_t row_count : {std::size_t{40}, std::size_t{3}}) {
    problem.training.rows.resize(row_count);
    problem.training.labels.resize(row_count);
    const RegressionForest forest =
        value_of(grow_forest(problem.features, problem.training, {5, 5, 0.4}, 1, 1));
    ASSERT_TRUE(validate(forest).has_value());
    for (const RegressionTree& tree : forest.trees) EXPECT_EQ(tree.leaf_count(), 1u);
    const double mean = std::accumulate(forest.labels.begin(), forest.labels.end(), 0.0) /
                        static_cast<double>(row_count);
    const ForestPrediction predicted =
        PreparedForest(forest, {}, 1).predict(problem.features, {0}, 1);
    EXPECT_NEAR(predicted.mean[0], mean, 1e-12);
  }
}

// Root splits at 0, its left child at -1; rows 0..4 lie left of -1, 5 and 6 between, 7..12 right.
TEST(LabelledTree, TakesOutASplitOfWhichOneSideIsTooSmall) {
  const std::vector<TreeNode> grown = {{0, 0.0F, 1, 4}, {0, -1.0F, 2, 3}};
  FeatureRows features;
  features.names = {"factor"};
  features.row_count = 13;
  features.values = {-2, -2, -2, -2, -2, -0.5, -0.5, 1, 1, 1, 1, 1, 1};
  std::vector<const float*> rows;
  for (std::size_t i = 0; i < 13; ++i) rows.push_back(features.row(i));
  EXPECT_EQ(labelled_tree(grown, rows, 2).nodes, grown);
  EXPECT_EQ(labelled_tree(grown, rows, 3).nodes, (std::vector<TreeNode>{{0, 0.0F, 1, 2}}));
  EXPECT_EQ(labelled_tree(grown, rows, 8).leaf_count(), 1u);
}

}  // namespace

}  // namespace sightline
