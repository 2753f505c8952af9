#include "passes/trajectory/graph/best_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace sightline {
namespace {

const std::vector<Eigen::Vector3d> kPoints_m = {{10.0, 0.0, 0.0}};

// Of a scan that fits best at a scale; its logarithm is a parabola.
MatchAtScale best_at(double scale, bool is_sure = true) {
  return [=](const std::vector<Eigen::Vector3d>& scaled_m) {
    const double off = scaled_m[0].x() / kPoints_m[0].x() - scale;
    return FitAtScale{2.0 * std::exp(-off * off / (2.0 * 0.02 * 0.02)), is_sure};
  };
}

TEST(BestScale, IsTheTopOfTheParabola) {
  for (double scale = 0.966; scale <= 1.034; scale += 0.0013) {
    const std::optional<double> found = best_scale(kPoints_m, best_at(scale));
    ASSERT_TRUE(found.has_value()) << scale;
    EXPECT_NEAR(*found, scale, 1e-9);
  }
}

TEST(BestScale, IsNotKnownBeyondTheScalesThatAreTriedOrWhereNoMatchIsSure) {
  EXPECT_FALSE(best_scale(kPoints_m, best_at(0.95)));
  EXPECT_FALSE(best_scale(kPoints_m, best_at(1.05)));
  EXPECT_FALSE(best_scale(kPoints_m, best_at(1.0, false)));
}

TEST(BestScale, MatchesEachScaleOnce) {
  std::multiset<double> tried;
  const MatchAtScale match = [&](const std::vector<Eigen::Vector3d>& scaled_m) {
    tried.insert(scaled_m[0].x());
    return best_at(1.013)(scaled_m);
  };
  ASSERT_TRUE(best_scale(kPoints_m, match));
  EXPECT_EQ(std::set<double>(tried.begin(), tried.end()).size(), tried.size());
  EXPECT_LE(tried.size(), 12U);
}

TEST(CommonRatio, IsTheMedianOfScansThatAgree) {
  EXPECT_EQ(common_ratio({1.01, 1.012, 1.008}), 1.01);
  EXPECT_EQ(common_ratio({0.99, 0.992, 1.0, 0.988}), 0.992) << "three of four";
  EXPECT_EQ(common_ratio({0.99, 0.992, 1.0, 1.001}), 1.0) << "two of four";
  EXPECT_EQ(common_ratio({1.0029, 1.0029, 1.0029}), 1.0) << "too little";
  EXPECT_EQ(common_ratio({1.01, 1.01}), 1.0) << "too few";
  EXPECT_EQ(common_ratio({}), 1.0);
}

}  // namespace
}  // namespace sightline
