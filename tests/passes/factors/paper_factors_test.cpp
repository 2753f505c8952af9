#include "passes/factors/paper_factors.h"

#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <limits>

#include "formats/base/random.h"
#include "passes/map/build_ndt.h"
#include "tests/passes/factors/plain_factors.h"
#include "tests/support/toy_world.h"

namespace sightline {
namespace {

Nd nd_at(double x_m) {
  Nd nd;
  nd.mean_m = {x_m, 0.0, 0.0};
  nd.key = cell_key(nd.mean_m, 2.0);
  return nd;
}

TEST(Vicinity, HoldsNdsNearestFirstAndThoseAtExactlyTheRange) {
  const std::vector<Nd> nds = {nd_at(30.0), nd_at(10.0), nd_at(5.0), nd_at(10.5), nd_at(30.5)};
  const std::vector<std::uint32_t> all = {0, 1, 2, 3, 4};
  const Vicinity vicinity = vicinity_of(Eigen::Vector3d::Zero(), nds, all, {10.0, 20.0, 30.0});
  EXPECT_EQ(vicinity.nd_index, (std::vector<std::uint32_t>{2, 1, 3, 0}));
  EXPECT_EQ(vicinity.end, (std::vector<std::size_t>{2, 3, 4}));
  EXPECT_EQ(feature_count(vicinity), (std::vector<double>{2.0, 3.0, 4.0}));
}

TEST(Vicinity, BreaksTiesOfDistanceByCellKey) {
  const std::vector<Nd> nds = {nd_at(5.0), nd_at(-5.0)};
  const std::vector<std::uint32_t> forward = {0, 1};
  const std::vector<std::uint32_t> backward = {1, 0};
  const Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  EXPECT_EQ(vicinity_of(p_m, nds, forward, {10.0}).nd_index, (std::vector<std::uint32_t>{1, 0}));
  EXPECT_EQ(vicinity_of(p_m, nds, backward, {10.0}).nd_index, (std::vector<std::uint32_t>{1, 0}));
}

TEST(Vicinity, LooksOnlyAtCandidates) {
  const std::vector<Nd> nds = {nd_at(1.0), nd_at(3.0), nd_at(5.0)};
  const std::vector<std::uint32_t> some = {2};
  EXPECT_EQ(vicinity_of(Eigen::Vector3d::Zero(), nds, some, {10.0}).nd_index, some);
}

TEST(Dimensions, CountsEachClassWithinEachRange) {
  Vicinity vicinity;
  vicinity.ranges_m = {10.0, 20.0};
  vicinity.nd_index = {0, 1, 2, 3, 4};
  vicinity.end = {2, 5};
  const std::vector<int> dimension_class = {2, 1, 2, 3, 2};
  EXPECT_EQ(dimension_counts(vicinity, dimension_class),
            (std::vector<ByDimension>{{1.0, 1.0, 0.0}, {1.0, 3.0, 1.0}}));
}

TEST(Dimensions, RatiosAreSharesAndAllZeroOfNothing) {
  EXPECT_EQ(dimension_ratios({1.0, 3.0, 4.0}), (ByDimension{0.125, 0.375, 0.5}));
  EXPECT_EQ(dimension_ratios({0.0, 0.0, 0.0}), (ByDimension{0.0, 0.0, 0.0}));
}

Eigen::Vector3d random_direction(Random& random) {
  const Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
  return direction.normalized();
}

TEST(NormalEntropy, PutsVerticalsIntoTheCapAndHorizontalsOnTheRim) {
  EXPECT_EQ(normal_bin({0.0, 0.0, 1.0}), 0);
  EXPECT_EQ(normal_bin({0.0, 0.0, -1.0}), 0);
  EXPECT_EQ(normal_bin({1.0, 0.0, 0.0}), 1);
  EXPECT_EQ(normal_bin({0.0, 1.0, 0.0}), 1 + 9);  // 90 degrees of sectors of 10
}

TEST(NormalEntropy, GivesANormalAndItsOppositeTheSameBin) {
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    Eigen::Vector3d direction = random_direction(random);
    if (i % 4 == 0) direction = Eigen::Vector3d(direction.x(), direction.y(), 0.0).normalized();
    ASSERT_EQ(normal_bin(direction), normal_bin(-direction)) << direction.transpose();
  }
}

TEST(NormalEntropy, UsesBinsOfEqualArea) {
  constexpr int kSamples = 146000;  // 2000 a bin
  Random random(2);
  std::array<int, kNormalBinCount> histogram{};
  for (int i = 0; i < kSamples; ++i) {
    ++histogram.at(static_cast<std::size_t>(normal_bin(random_direction(random))));
  }
  // Five standard deviations of a count of 2000.
  for (const int count : histogram) EXPECT_NEAR(count, 2000, 5.0 * std::sqrt(2000.0));
}

TEST(NormalEntropy, IsTheEntropyOfPlanarNdsAlone) {
  Vicinity vicinity;
  vicinity.ranges_m = {10.0, 20.0, 30.0};
  vicinity.nd_index = {0, 1, 2, 3, 4};
  vicinity.end = {1, 3, 5};
  const std::vector<int> bins = {-1, 4, 9, 9, 4};
  const std::vector<double> entropy = normal_entropy(vicinity, bins);
  EXPECT_EQ(entropy[0], 0.0);  // no planar ND
  EXPECT_DOUBLE_EQ(entropy[1], 1.0);
  EXPECT_DOUBLE_EQ(entropy[2], 1.0);
}

TEST(OccupancyRatio, CountsCellsHitWithinEachRangeAndAtExactlyIt) {
  const float nothing = std::numeric_limits<float>::infinity();
  const std::vector<float> distance_m = {5.0F, 10.0F, 10.5F, nothing, 20.0F, 20.5F, 3.0F, nothing};
  EXPECT_EQ(occupancy_ratio(distance_m, {10.0, 20.0, 50.0}),
            (std::vector<double>{3.0 / 8.0, 5.0 / 8.0, 6.0 / 8.0}));
}

TEST(OccupancyRatio, IsOfTheCellsInView) {
  const float out = std::numeric_limits<float>::quiet_NaN();
  const float nothing = std::numeric_limits<float>::infinity();
  EXPECT_EQ(occupancy_ratio(std::vector<float>{out, 5.0F, out, nothing, 15.0F, out, nothing},
                            {10.0, 20.0}),
            (std::vector<double>{1.0 / 4.0, 2.0 / 4.0}));
  EXPECT_EQ(occupancy_ratio(std::vector<float>{out, out}, {10.0}), (std::vector<double>{0.0}));
}

TEST(RAverage, IsTheMeanDistanceAndTheRangeItselfWhereThereIsNothing) {
  Vicinity vicinity;
  vicinity.ranges_m = {5.0, 10.0, 20.0};
  vicinity.nd_index = {0, 1, 2};
  vicinity.distance_m = {6.0, 8.0, 16.0};
  vicinity.end = {0, 2, 3};
  EXPECT_EQ(r_average(vicinity), (std::vector<double>{5.0, 7.0, 10.0}));
}

constexpr std::size_t kNoShift = kShiftCount / 2;

// One round ND of variance 0.04 m^2 in the middle of cell (0, 0, 0).
NdtMap one_round_nd() {
  NdtMap map;
  Nd nd;
  nd.point_count = 10;
  nd.mean_m = {1.0, 1.0, 1.0};
  nd.covariance_m2 = 0.04 * Eigen::Matrix3d::Identity();
  decompose(nd);
  map.nds.push_back(nd);
  return map;
}

TEST(SelfScore, OfARoundNdIsWhatOneComputesByHand) {
  const NdtMap map = one_round_nd();
  const ShiftGrid score = self_score(map.nds[0], make_match_grid(map));
  const double d2 = gauss_constants(2.0).d2;
  // The mean scores 1; the four others are one sigma away.
  EXPECT_NEAR(score[kNoShift], 1.0 + 4.0 * std::exp(-0.5 * d2), 1e-12);
  // Moved by 0.25 m, 1.25 sigma: the mean, and four at 1.25 +- 1 sigma and twice across.
  const double m2 = 1.25 * 1.25;
  const double expected = std::exp(-0.5 * d2 * m2) + std::exp(-0.5 * d2 * 2.25 * 2.25) +
                          std::exp(-0.5 * d2 * 0.25 * 0.25) +
                          2.0 * std::exp(-0.5 * d2 * (m2 + 1.0));
  // Eigenvectors of a round ND are the axes, in some order of two of the three.
  const double along_z = std::exp(-0.5 * d2 * m2) + 4.0 * std::exp(-0.5 * d2 * (m2 + 1.0));
  const double found = score[kNoShift + 1];
  EXPECT_TRUE(std::abs(found - expected) < 1e-12 || std::abs(found - along_z) < 1e-12);
}

TEST(SelfScore, IsZeroWhereTheShiftedSamplesLeaveAllValidCells) {
  const NdtMap map = one_round_nd();
  const ShiftGrid score = self_score(map.nds[0], make_match_grid(map));
  // Two metres along x and y: all five samples are in cell (1, 1, 0).
  EXPECT_EQ(score[kShiftCount - 1], 0.0);
}

TEST(SelfScore, EqualsThePlainSumForAnyCellSize) {
  for (const double cell_m : {0.7, 1.0, 2.0, 5.0}) {
    const NdtMap map = random_ndt_map(1, 300, 8.0 * cell_m, cell_m, 64.0 * cell_m);
    const MatchGrid grid = make_match_grid(map);
    const plain::NdByCell cells = plain::by_cell(map);
    for (std::size_t i = 0; i < map.nds.size(); i += 29) {
      const ShiftGrid score = self_score(map.nds[i], grid);
      const std::vector<double> expected = plain::self_score(map.nds[i], cells, cell_m);
      for (std::size_t v = 0; v < kShiftCount; ++v) {
        ASSERT_NEAR(score[v], expected[v], 1e-10) << "cell " << cell_m << " shift " << v;
      }
    }
  }
}

TEST(SelfScore, SumsSendersShellByShell) {
  std::vector<ShiftGrid> score_of(3);
  score_of[0].fill(1.0);
  score_of[1].fill(10.0);
  score_of[2].fill(100.0);
  Vicinity vicinity;
  vicinity.ranges_m = {10.0, 20.0};
  vicinity.nd_index = {2, 0, 1};
  vicinity.end = {1, 3};
  const std::vector<ShiftGrid> sums = self_scores(vicinity, score_of);
  EXPECT_EQ(sums[0][7], 100.0);
  EXPECT_EQ(sums[1][7], 111.0);
}

TEST(SelfScore, OfALongWallFallsLessAlongItThanAcross) {
  const ToyWorld world = draw_world("########################\n");
  const NdtMap map = ndt_from_points(world.points.points_m, world.points.frame, {}, 1);
  const MatchGrid grid = make_match_grid(map);
  ShiftGrid sum{};
  for (const Nd& nd : map.nds) {
    const ShiftGrid score = self_score(nd, grid);
    for (std::size_t v = 0; v < kShiftCount; ++v) sum[v] += score[v];
  }
  const double along = sum[kNoShift + 4];
  const double across = sum[kNoShift + 4 * kShiftsPerAxis];
  EXPECT_GT(along, 0.7 * sum[kNoShift]);
  EXPECT_LT(across, 0.8 * along);
}

const double kLog289 = std::log2(289.0);

TEST(ScoreEntropy, IsLargestWhereNothingTellsShiftsApart) {
  ShiftGrid score;
  score.fill(3.0);
  EXPECT_NEAR(score_entropy(score), kLog289, 1e-12);
  score.fill(0.0);
  EXPECT_EQ(score_entropy(score), kLog289);
}

TEST(ScoreEntropy, OfOnePeakIsTheEntropyOfOneWeightAmongMany) {
  ShiftGrid score{};
  score[144] = 5.0;
  // Softmax of 10 for the peak and 0 for the 288 others.
  const double total = std::exp(10.0) + 288.0;
  const double peak = std::exp(10.0) / total;
  const double other = 1.0 / total;
  EXPECT_NEAR(score_entropy(score), -peak * std::log2(peak) - 288.0 * other * std::log2(other),
              1e-12);
}

TEST(ScoreEntropy, DoesNotDependOnTheScale) {
  ShiftGrid score;
  ShiftGrid scaled;
  for (std::size_t v = 0; v < kShiftCount; ++v) {
    score[v] = std::cos(0.1 * static_cast<double>(v)) + 1.5;
    scaled[v] = 1000.0 * score[v];
  }
  EXPECT_NEAR(score_entropy(score), score_entropy(scaled), 1e-12);
}

TEST(Flat050, IsTheBestOfTheTwelveShiftsOfAboutHalfAMetre) {
  ShiftGrid score{};
  score[kNoShift] = 4.0;
  score[kNoShift + 1] = 3.9;                       // 0.25 m: too near
  score[kNoShift + kShiftsPerAxis + 1] = 3.8;      // 0.35 m: too near
  score[kNoShift + 2 * kShiftsPerAxis + 2] = 3.7;  // 0.71 m: too far
  score[kNoShift - 2] = 2.0;                       // 0.5 m
  score[kNoShift - 2 * kShiftsPerAxis + 1] = 3.0;  // 0.56 m
  EXPECT_EQ(flat_050(score), 0.75);
}

TEST(Flat050, MayExceedOne) {
  ShiftGrid score{};
  score[kNoShift] = 1.0;
  score[kNoShift + 2] = 2.0;
  EXPECT_EQ(flat_050(score), 2.0);
}

TEST(Flat050, IsOneWhereNothingScores) { EXPECT_EQ(flat_050(ShiftGrid{}), 1.0); }

}  // namespace
}  // namespace sightline
