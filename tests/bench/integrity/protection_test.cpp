#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

#include "formats/base/random.h"
#include "tests/bench/integrity/protection_samples.h"

namespace sightline {
namespace {

// Matches that are as wrong as their covariances state.
KindSample sample_of(Random& random, const std::string& kind, std::uint64_t seed,
                     std::size_t scan) {
  KindSample sample{kind, seed, scan, {}};
  MatchSample& match = sample.sample;
  const double sigmas[] = {0.02, 0.02, 0.02, 0.002, 0.002, 0.002};
  const InformationScale scale = default_information_scale();
  for (int i = 0; i < 6; ++i) {
    const double map = i < 3 ? scale.map_m : scale.map_rad;
    match.structure.information(i, i) = scale.variance_factor / (sigmas[i] * sigmas[i] - map * map);
    match.found[i] = sigmas[i] * random.normal();
  }
  const Matrix6d start = tracking_start_covariance();
  for (int i = 0; i < 6; ++i) match.start[i] = std::sqrt(start(i, i)) * random.normal();
  match.likelihood = 3.0 + 0.1 * random.normal();
  match.point_count = 1000;
  match.scored_points = 990;
  return sample;
}

std::vector<Block> blocks_of_streets(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<KindSample> samples;
  for (std::size_t k = 0; k < 60 * count; ++k) {
    samples.push_back(sample_of(random, "streets", seed, k));
  }
  return blocks_of(samples);
}

std::size_t exceeding(const std::vector<Block>& blocks, const ProtectionRow& row,
                      std::size_t axis) {
  return static_cast<std::size_t>(std::ranges::count_if(blocks, [&](const Block& block) {
    return std::ranges::any_of(block.samples, [&](const MatchSample& sample) {
      const AxisErrors found = returned_errors(sample, row.covariance_factor);
      return std::abs(found.errors[axis]) > row.percent_factors[axis] * found.sigmas[axis];
    });
  }));
}

TEST(FittedRows, AreExceededInAboutOneOfAHundredBlocksOfOtherPlaces) {
  const ProtectionRow row = fitted_rows(blocks_of_streets(1, 300))[0];
  EXPECT_EQ(row.block_count, 300u);
  EXPECT_NEAR(row.covariance_factor, 1.0, 0.1);
  const std::vector<Block> others = blocks_of_streets(2, 300);
  for (std::size_t axis = 0; axis < kProtectionAxes; ++axis) {
    EXPECT_LE(exceeding(others, row, axis), 12u) << axis;
    EXPECT_LT(row.percent_factors[axis], 6.0) << axis;
  }
}

TEST(FittedRows, HaveNoBoundOfFewerThanNinetyNineBlocks) {
  EXPECT_EQ(fitted_rows(blocks_of_streets(3, 98))[0].percent_factors[1], kUnavailable);
  EXPECT_LT(fitted_rows(blocks_of_streets(3, 99))[0].percent_factors[1], kUnavailable);
}

TEST(FittedRows, OfAGroupOfFewBlocksHaveTheBoundsOfAll) {
  std::vector<Block> blocks = blocks_of_streets(4, 99);
  Random random(5);
  std::vector<KindSample> samples;
  for (std::size_t k = 0; k < 600; ++k) samples.push_back(sample_of(random, "tunnel", 5, k));
  for (Block& block : blocks_of(samples)) blocks.push_back(block);
  const auto rows = fitted_rows(blocks);
  EXPECT_EQ(rows[0].block_count, 99u);
  EXPECT_EQ(rows[1].block_count, 109u);
  EXPECT_EQ(rows[1].percent_factors, rows[3].percent_factors);
}

TEST(BlocksOf, LeavesOutWhatAKindOfPlaceDoesNotFill) {
  Random random(6);
  std::vector<KindSample> samples;
  for (std::size_t k = 0; k < 130; ++k) {
    samples.push_back(sample_of(random, k < 100 ? "tunnel" : "town", 6, k));
  }
  const std::vector<Block> blocks = blocks_of(samples);
  ASSERT_EQ(blocks.size(), 1u);
  EXPECT_EQ(blocks[0].samples.size(), 60u);
}

}  // namespace
}  // namespace sightline
