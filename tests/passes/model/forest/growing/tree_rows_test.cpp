#include "passes/model/forest/growing/tree_rows.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>
#include <vector>

namespace sightline {
namespace {

std::vector<std::uint32_t> samples_in_order(const TreeRows& rows, std::uint32_t feature) {
  std::vector<std::uint32_t> samples;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    samples.push_back(rows.sample_of(rows.order(feature)[i]));
  }
  return samples;
}

using Samples = std::vector<std::uint32_t>;

// Five samples of two features, of which the second and the fourth are not drawn.
struct Drawn {
  std::vector<std::vector<float>> values = {
      {3.0F, 0.0F}, {1.0F, 9.0F}, {1.0F, 2.0F}, {0.0F, 9.0F}, {2.0F, 1.0F}};
  std::vector<double> labels = {10.0, 20.0, 30.0, 40.0, 50.0};
  std::vector<std::uint32_t> draws = {4, 2, 0, 2};
  RankedColumns ranks{
      {values[0].data(), values[1].data(), values[2].data(), values[3].data(), values[4].data()},
      2};
  TreeRows rows{ranks, labels, draws};
};

TEST(TreeRows, AreTheSamplesDrawnInTheOrderOfEachFeature) {
  const Drawn drawn;
  ASSERT_EQ(drawn.rows.size(), 3U);
  EXPECT_EQ(samples_in_order(drawn.rows, 0), (Samples{2, 4, 0}));
  EXPECT_EQ(samples_in_order(drawn.rows, 1), (Samples{0, 4, 2}));
}

TEST(TreeRows, GiveTheCopiesOfASampleOneByOne) {
  Drawn drawn;
  const std::uint32_t row = drawn.rows.order(0)[0];  // of sample 2
  EXPECT_EQ(drawn.rows.copies(row).count(), 2.0);
  EXPECT_EQ(drawn.rows.copies(row).label_sum(), 60.0);
  EXPECT_EQ(drawn.rows.first_draw(row), 1U);
  EXPECT_EQ(drawn.rows.take_copy(row), 30.0);
  EXPECT_EQ(drawn.rows.copies(row).count(), 1.0);
  EXPECT_EQ(drawn.rows.copies(row).label_sum(), 30.0);
  EXPECT_EQ(drawn.rows.first_draw(row), 3U);
}

std::vector<Samples> rows_of_side(const TreeRows& rows, const std::vector<bool>& is_right,
                                  bool of_right) {
  std::vector<Samples> sides;
  for (std::uint32_t feature = 0; feature < 4; ++feature) {
    Samples& side = sides.emplace_back();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::uint32_t row = rows.order(feature)[i];
      if (is_right[row] == of_right) side.push_back(row);
    }
  }
  return sides;
}

TEST(TreeRows, KeepEachOrderOnBothSidesOfASplitOrOnOne) {
  std::mt19937 random(7);
  std::vector<std::vector<float>> values(200, std::vector<float>(4));
  std::vector<const float*> samples;
  for (std::vector<float>& row : values) {
    for (std::size_t k = 0; k < row.size(); ++k) {
      row[k] = static_cast<float>(random() % (1U << 3U * static_cast<unsigned>(k)));
    }
    samples.push_back(row.data());
  }
  std::vector<std::uint32_t> draws(200);
  for (std::uint32_t& draw : draws) draw = static_cast<std::uint32_t>(random() % 200);
  const RankedColumns ranks(samples, 4);
  const std::vector<double> labels(200, 0.0);
  for (const auto& [keeps_left, keeps_right] :
       {std::pair(true, true), {true, false}, {false, true}}) {
    TreeRows rows(ranks, labels, draws);
    std::vector<bool> is_right(rows.size());
    for (std::uint32_t row = 0; row < rows.size(); ++row) {
      is_right[row] = random() % 3 == 0;
      rows.set_side(row, is_right[row]);
    }
    const std::vector<Samples> left = rows_of_side(rows, is_right, false);
    const std::vector<Samples> right = rows_of_side(rows, is_right, true);
    const std::size_t at = left[3].size();
    rows.part({0, at, rows.size(), keeps_left, keeps_right}, 3);
    for (std::uint32_t feature = 1; feature < 4; ++feature) {
      const std::uint32_t* order = rows.order(feature);
      if (keeps_left) {
        EXPECT_EQ(Samples(order, order + at), left[feature]);
      }
      if (keeps_right) {
        EXPECT_EQ(Samples(order + at, order + rows.size()), right[feature]);
      }
    }
  }
}

}  // namespace
}  // namespace sightline
