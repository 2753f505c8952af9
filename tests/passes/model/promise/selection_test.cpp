#include "passes/model/promise/selection.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

// Sites x three ranges (10, 20, 30 m), one limit (0.1 m).
PredictedError predictions(const std::vector<std::vector<double>>& probabilities) {
  PredictedError predicted;
  predicted.looks = every_return_at({10.0, 20.0, 30.0});
  predicted.limits_m = {0.1};
  predicted.site_count = static_cast<std::uint32_t>(probabilities.size());
  for (const std::vector<double>& site : probabilities) {
    for (const double probability : site) {
      predicted.within_probability.push_back(probability);
      predicted.mean_m.push_back(0.2 * (1.0 - probability));
    }
  }
  predicted.extrapolated.assign(3 * probabilities.size(), 0);
  predicted.out_of_fold.assign(probabilities.size(), 0);
  predicted.has_history.assign(probabilities.size(), 0);
  return predicted;
}

std::vector<RoutePoint> straight_route(std::size_t count) {
  std::vector<RoutePoint> route;
  for (std::size_t i = 0; i < count; ++i) route.push_back({0, static_cast<double>(i)});
  return route;
}

TEST(Selection, TakesTheShortestRangeThatIsProbableEnough) {
  const PredictedError predicted = predictions({{0.5, 0.8, 0.9}, {0.9, 0.1, 0.9}});
  const Choice choice = choose_by_probability(predicted, 0, {0.8, 0.8});
  EXPECT_EQ(choice.range_index, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(choice.flags, (std::vector<std::uint8_t>{0, 0}));
}

TEST(Selection, TakesTheMostProbableWhereNoneIsGoodEnoughAndSaysSo) {
  const PredictedError predicted = predictions({{0.5, 0.6, 0.4}, {0.5, 0.7, 0.7}});
  const Choice choice = choose_by_probability(predicted, 0, {0.8, 0.8});
  EXPECT_EQ(choice.range_index, (std::vector<std::uint8_t>{1, 1})) << "the shortest of equals";
  EXPECT_EQ(choice.flags, (std::vector<std::uint8_t>{kUnmet, kUnmet}));
}

TEST(Selection, ByMeanCountsALimitThatIsMetExactly) {
  const PredictedError predicted = predictions({{0.4, 0.5, 0.9}});  // means 0.12, 0.1, 0.02
  EXPECT_EQ(choose_by_mean(predicted, 0.1).range_index[0], 1);
  EXPECT_EQ(choose_by_mean(predicted, 0.12).range_index[0], 0);
  EXPECT_EQ(choose_by_mean(predicted, 0.01).flags[0], kUnmet);
}

TEST(Selection, FlagsSitesWhoseOwnAnswerIsExtrapolatedAndNoOthers) {
  PredictedError predicted = predictions({{0.9, 0.9, 0.9}, {0.9, 0.9, 0.9}, {0.1, 0.9, 0.9}});
  predicted.extrapolated = {0, 1, 1, 1, 0, 0, 1, 0, 0};
  Choice choice = choose_by_probability(predicted, 0, {0.8, 0.8});
  mark_extrapolated(predicted, choice);
  EXPECT_EQ(choice.range_index, (std::vector<std::uint8_t>{0, 0, 1}));
  EXPECT_EQ(choice.flags, (std::vector<std::uint8_t>{0, kExtrapolated, 0}));
}

TEST(Selection, DilatesByThreeMetresAlongTheRunOnly) {
  std::vector<RoutePoint> route = straight_route(9);
  for (std::size_t i = 6; i < 9; ++i) route[i] = {1, static_cast<double>(i - 6)};
  Choice choice = choose_everywhere(0, 9);
  choice.range_index = {0, 0, 0, 0, 2, 0, 0, 0, 1};
  dilate(route, 3.0, choice);
  EXPECT_EQ(choice.range_index, (std::vector<std::uint8_t>{0, 2, 2, 2, 2, 2, 1, 1, 1}));
  EXPECT_EQ(choice.reasons[3], Reason::kDilation);
  EXPECT_EQ(choice.reasons[4], Reason::kNone) << "its own";
}

TEST(Selection, DilatesAsBruteForceDoes) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    std::vector<RoutePoint> route;
    Choice choice;
    for (std::uint32_t run = 0; run < 3; ++run) {
      double s_m = 0.0;
      for (int i = 0; i < 20; ++i) {
        route.push_back({run, s_m});
        s_m += random.uniform(0.2, 2.0);
        choice.range_index.push_back(static_cast<std::uint8_t>(random.below(9)));
      }
    }
    choice.flags.assign(60, 0);
    choice.reasons.assign(60, Reason::kModel);
    const Choice before = choice;
    dilate(route, 3.0, choice);
    for (std::size_t i = 0; i < route.size(); ++i) {
      std::uint8_t expected = 0;
      for (std::size_t j = 0; j < route.size(); ++j) {
        const bool is_near =
            route[i].run == route[j].run && std::abs(route[i].s_m - route[j].s_m) <= 3.0;
        if (is_near) expected = std::max(expected, before.range_index[j]);
      }
      EXPECT_EQ(choice.range_index[i], expected);
    }
  }
}

TEST(Selection, ALooserLimitNeverLooksFurtherThanATighter) {
  Choice tighter = choose_everywhere(0, 3), looser = tighter;
  tighter.range_index = {1, 2, 2};
  tighter.flags = {0, kUnmet, 0};
  looser.range_index = {2, 2, 0};
  looser.flags = {kUnmet, kUnmet, 0};
  cap_by_tighter(tighter, looser);
  EXPECT_EQ(looser.range_index, (std::vector<std::uint8_t>{1, 2, 0}));
  EXPECT_EQ(looser.flags, (std::vector<std::uint8_t>{0, kUnmet, 0}));
  EXPECT_EQ(looser.reasons,
            (std::vector<Reason>{Reason::kTighterLimit, Reason::kNone, Reason::kNone}));
}

TEST(Selection, ARangeThatIsTakenOverFromATighterLimitBringsItsKind) {
  Choice tighter = choose_everywhere(0, 3), looser = tighter;
  tighter.range_index = {1, 1, 2};
  tighter.flags = {kStatic, 0, kStatic};
  looser.range_index = {2, 2, 2};
  looser.flags = {0, kStatic, 0};
  cap_by_tighter(tighter, looser);
  EXPECT_EQ(looser.flags, (std::vector<std::uint8_t>{kStatic, 0, 0}));
}

TEST(Selection, AStricterThresholdNeverLooksLessFar) {
  Random random(1);
  std::vector<std::vector<double>> probabilities;
  for (int i = 0; i < 200; ++i) {
    probabilities.push_back({random.uniform(), random.uniform(), random.uniform()});
  }
  const PredictedError predicted = predictions(probabilities);
  Choice before = choose_by_probability(predicted, 0, {0.0, 0.0});
  for (double threshold = 0.05; threshold <= 1.0; threshold += 0.05) {
    Choice choice = choose_by_probability(predicted, 0, {threshold, threshold});
    dilate(straight_route(200), 3.0, choice);
    for (std::size_t i = 0; i < 200; ++i) EXPECT_GE(choice.range_index[i], before.range_index[i]);
    before = choice;
  }
}

}  // namespace
}  // namespace sightline
