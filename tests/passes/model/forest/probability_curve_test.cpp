#include "passes/model/forest/probability_curve.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

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

}  // namespace
}  // namespace sightline
