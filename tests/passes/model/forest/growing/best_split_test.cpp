#include "passes/model/forest/growing/best_split.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

#include "passes/model/forest/growing/grow_tree.h"

namespace sightline {
namespace {

// Every place of every order, one after another, by the formula.
Split by_the_formula(const TreeRows& rows, const Part& part,
                     const std::vector<std::uint32_t>& features) {
  Split best;
  for (const std::uint32_t feature : features) {
    const std::uint32_t* order = rows.order(feature);
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t i = part.begin; i + 1 < part.end; ++i) {
      sum += rows.copies(order[i]).label_sum();
      count += rows.copies(order[i]).count();
      if (rows.ranks(feature)[order[i]] == rows.ranks(feature)[order[i + 1]]) continue;
      const double right_sum = part.label_sum - sum;
      const double right_count = static_cast<double>(part.size) - count;
      const double score = sum * sum / count + right_sum * right_sum / right_count;
      if (score <= best.score) continue;
      best = {score, sum, static_cast<std::size_t>(count), i + 1, feature};
    }
  }
  return best;
}

void expect_equal(const Split& found, const Split& wanted) {
  EXPECT_EQ(found.score, wanted.score);
  EXPECT_EQ(found.feature, wanted.feature);
  EXPECT_EQ(found.at, wanted.at);
  EXPECT_EQ(found.left_sum, wanted.left_sum);
  EXPECT_EQ(found.left_size, wanted.left_size);
}

enum class Labels { kAny, kTwo, kOne };

double label_of(Labels labels, std::mt19937& random) {
  std::lognormal_distribution<double> any(-2.5, 1.5);
  if (labels == Labels::kOne) return 0.3;
  if (labels == Labels::kTwo) return random() % 2 == 0 ? 0.0 : 0.1;
  return summable_label(any(random));
}

// Few values make ties between rows, few labels make equal scores.
TEST(BestSplit, IsTheFirstOfTheHighestScoreByTheFormula) {
  std::mt19937 random(11);
  for (const std::size_t size : {2U, 3U, 5U, 16U, 17U, 18U, 19U, 20U, 21U, 300U}) {
    for (const unsigned value_count : {1U, 2U, 5U, 100000U}) {
      for (const Labels kind : {Labels::kAny, Labels::kTwo, Labels::kOne}) {
        constexpr std::size_t kFeatures = 6;
        std::vector<std::vector<float>> values(size, std::vector<float>(kFeatures));
        std::vector<const float*> samples;
        std::vector<double> labels;
        for (std::vector<float>& row : values) {
          for (float& value : row) value = static_cast<float>(random() % value_count);
          samples.push_back(row.data());
          labels.push_back(summable_label(label_of(kind, random)));
        }
        std::vector<std::uint32_t> draws(size);
        std::iota(draws.begin(), draws.end(), 0U);
        for (std::size_t i = 0; i < size; ++i)
          draws.push_back(static_cast<std::uint32_t>(random() % size));
        const RankedColumns ranks(samples, kFeatures);
        const TreeRows rows(ranks, labels, draws);
        Part part{0.0, 0, rows.size(), draws.size(), 0, 0};
        for (const std::uint32_t draw : draws) part.label_sum += labels[draw];
        const std::vector<std::uint32_t> features = {4, 1, 0, 5};
        expect_equal(best_split(rows, part, features), by_the_formula(rows, part, features));
      }
    }
  }
}

}  // namespace
}  // namespace sightline
