#include "passes/model/forest/growing/grow_tree.h"

#include <dlib/rand.h>
#include <dlib/random_forest.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include "passes/model/forest/growing/tree_rows.h"

namespace sightline {
namespace {

struct Problem {
  std::vector<std::vector<float>> values;
  TreeSamples samples;

  Problem(std::uint32_t seed, std::size_t rows, std::size_t features, int value_count) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> value(-value_count, value_count);
    std::normal_distribution<double> noise(0.0, 0.3);
    for (std::size_t i = 0; i < rows; ++i) {
      std::vector<float> row;
      for (std::size_t k = 0; k < features; ++k) {
        row.push_back(static_cast<float>(value(random)) / static_cast<float>(value_count));
      }
      samples.labels.push_back(summable_label(row[0] * row[features - 1] + noise(random)));
      values.push_back(std::move(row));
    }
    for (const std::vector<float>& row : values) samples.rows.push_back(row.data());
    samples.feature_count = features;
  }
};

auto tree_of_dlib(const TreeSamples& samples, const TreeOptions& options, std::uint64_t seed) {
  using Sample = dlib::matrix<double, 0, 1>;
  std::vector<Sample> rows;
  for (const float* row : samples.rows) {
    Sample sample(static_cast<long>(samples.feature_count));
    for (long k = 0; k < sample.size(); ++k) sample(k) = row[k];
    rows.push_back(sample);
  }
  dlib::random_forest_regression_trainer<dlib::dense_feature_extractor> trainer;
  trainer.set_num_trees(1);
  trainer.set_min_samples_per_leaf(options.least_leaf_rows);
  trainer.set_feature_subsampling_fraction(options.feature_share);
  trainer.set_seed(std::to_string(seed) + "/");
  return trainer.train(rows, samples.labels);
}

void expect_tree_of_dlib(const Problem& problem, const TreeOptions& options, std::uint64_t seed) {
  const RankedColumns ranks(problem.samples.rows, problem.samples.feature_count);
  const GrownTree tree = grow_tree(problem.samples, ranks, options, seed);
  const auto judge = tree_of_dlib(problem.samples, options, seed);
  const auto& nodes = judge.get_internal_tree_nodes()[0];
  ASSERT_EQ(tree.nodes.size(), nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const TreeNode wanted{nodes[i].split_feature, nodes[i].split_threshold, nodes[i].left,
                          nodes[i].right};
    ASSERT_EQ(tree.nodes[i], wanted) << "node " << i;
  }
  EXPECT_EQ(tree.leaf_values, judge.get_tree_leaves()[0]);
}

TEST(GrowTree, GivesTheTreeOfDlibBitForBit) {
  for (const std::size_t rows : {1U, 2U, 5U, 6U, 7U, 41U, 300U, 5000U}) {
    for (const int value_count : {1, 3, 40, 1'000'000}) {
      const auto seed = static_cast<std::uint32_t>(rows) + static_cast<std::uint32_t>(value_count);
      SCOPED_TRACE(std::to_string(rows) + " rows, values " + std::to_string(value_count));
      const Problem problem(seed, rows, 5, value_count);
      expect_tree_of_dlib(problem, {5, 0.4}, seed);
      expect_tree_of_dlib(problem, {1, 1.0}, seed);
    }
  }
}

TEST(GrowTree, OfOneFeatureThatIsAlwaysTheSameSplitsAsDlibDoes) {
  Problem problem(1, 30, 1, 1);
  for (std::vector<float>& row : problem.values) row[0] = 2.0F;
  expect_tree_of_dlib(problem, {5, 1.0}, 3);
}

TEST(SummableLabel, AddsUpToTheSameInAnyOrder) {
  std::mt19937 random(3);
  std::lognormal_distribution<double> label(-2.5, 1.5);
  std::vector<double> labels(8000);
  for (double& one : labels) {
    const double exact = label(random);
    one = summable_label(exact);
    EXPECT_NEAR(one, exact, 0.6e-9);
  }
  const double sum = std::accumulate(labels.begin(), labels.end(), 0.0);
  for (int i = 0; i < 20; ++i) {
    std::ranges::shuffle(labels, random);
    EXPECT_EQ(std::accumulate(labels.begin(), labels.end(), 0.0), sum);
  }
}

TEST(RankedColumns, OrderAndTellEqualAsTheValuesDo) {
  const std::vector<float> values = {3.0F, -0.0F, 0.0F, -1e30F, 3.0F, 1e-40F, -1e-40F, 2.0F};
  std::vector<const float*> rows;
  for (const float& value : values) rows.push_back(&value);
  const RankedColumns ranks(rows, 1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      EXPECT_EQ(values[i] < values[k], ranks.column(0)[i] < ranks.column(0)[k]);
    }
  }
  const std::vector<std::uint32_t> order(ranks.order(0).begin(), ranks.order(0).end());
  EXPECT_EQ(order, (std::vector<std::uint32_t>{3, 6, 1, 2, 5, 7, 0, 4}));
}

TEST(SortKeyedRows, IsAStableSort) {
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    const int bits = static_cast<int>(random() % 33);
    std::vector<KeyedRow> rows(random() % 1500);
    for (std::uint32_t k = 0; k < rows.size(); ++k) {
      const std::uint64_t key = random() & ((std::uint64_t{1} << static_cast<unsigned>(bits)) - 1);
      rows[k] =
          keyed_row(static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(random() % 100));
    }
    std::vector<KeyedRow> wanted = rows;
    std::ranges::stable_sort(wanted, {}, key_of);
    std::vector<KeyedRow> scratch(rows.size());
    sort_keyed_rows(rows, scratch, bits);
    ASSERT_EQ(rows, wanted) << "bits " << bits << ", " << rows.size() << " rows";
  }
}

constexpr std::size_t kLargest = std::numeric_limits<long long>::max();

// Many numbers, of ranges of all sizes: the largest reject about every second number.
void expect_numbers_of_dlib(std::uint64_t seed) {
  TreeRandom random(seed);
  dlib::rand judge(std::to_string(seed) + "/0");
  for (std::size_t i = 0; i < 5000; ++i) {
    const std::size_t end = kLargest >> i % 63;
    const std::size_t begin = i % 7 == 0 ? end / 3 : 0;
    const auto wanted =
        judge.get_integer_in_range(static_cast<long long>(begin), static_cast<long long>(end));
    ASSERT_EQ(random.in_range(begin, end), static_cast<std::size_t>(wanted)) << "number " << i;
  }
}

TEST(TreeRandom, DrawsTheNumbersOfDlib) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    for (const std::uint64_t seed : {i, i * 0x9e3779b97f4a7c15U}) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      expect_numbers_of_dlib(seed);
    }
  }
}

TEST(TreeRandom, OfAnEmptyRangeDrawsNothing) {
  TreeRandom random(1);
  TreeRandom other(1);
  EXPECT_EQ(random.in_range(5, 5), 5U);
  EXPECT_EQ(random.in_range(0, 1000), other.in_range(0, 1000));
}

}  // namespace

}  // namespace sightline
