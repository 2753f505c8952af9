#include "passes/model/forest/forest_prediction.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/support/handmade_model.h"

namespace sightline {
namespace {

// Pairs that come true as a curve says.
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
  const ErrorModel useless = three_features({-0.02, 0.0, 0.0});
  EXPECT_EQ(Support(useless, 0.25).outside_share(far.data(), 0), 0.0);
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

}  // namespace

}  // namespace sightline
