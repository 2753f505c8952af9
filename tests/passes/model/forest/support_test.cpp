#include "passes/model/forest/support.h"

#include <gtest/gtest.h>

#include "tests/support/handmade_model.h"

namespace sightline {
namespace {

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
