#include "passes/trajectory/following/way_filter.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

constexpr double kStep_s = 0.1;

// At 10 m/s.
WayFilter known_filter() {
  WayFilter filter;
  filter.begin(10.0);
  return filter;
}

TEST(WayFilter, KeepsTheSpeedWithoutMeasurementsAndKnowsThePlaceLess) {
  WayFilter filter = known_filter();
  filter.predict(kStep_s);
  const double first_m = filter.sigma_m();
  EXPECT_NEAR(first_m, std::hypot(0.01, 0.05), 0.002);
  for (int i = 0; i < 50; ++i) filter.predict(kStep_s);
  EXPECT_EQ(filter.way_m(kStep_s), 1.0);
  EXPECT_NEAR(filter.sigma_m(), 0.15, 1e-9) << "the farthest";
}

TEST(WayFilter, FollowsASpeedThatChangesByPlacesThatSurfacesMeasure) {
  WayFilter filter = known_filter();
  double true_way_m = 1.0;
  double ahead_m = 0.0;  // of the true place before that of the filter
  for (int i = 0; i < 60; ++i) {
    true_way_m -= 0.0015;
    filter.predict(kStep_s);
    ahead_m += true_way_m - filter.way_m(kStep_s);
    const double share =
        std::pow(filter.sigma_m(), 2.0) / (std::pow(filter.sigma_m(), 2.0) + std::pow(0.06, 2.0));
    const double off_m = share * ahead_m;
    filter.take_estimate(off_m, 0.06);
    ahead_m -= off_m;
  }
  EXPECT_NEAR(filter.way_m(kStep_s), true_way_m, 0.01);
  EXPECT_LT(std::abs(ahead_m), 0.06);
}

TEST(WayFilter, AMeasurementIsAnEstimateByItsShare) {
  WayFilter measured = known_filter();
  WayFilter estimated = known_filter();
  measured.predict(kStep_s);
  estimated.predict(kStep_s);
  const double place_m2 = estimated.sigma_m() * estimated.sigma_m();
  measured.take_measurement(0.1, 0.05);
  estimated.take_estimate(0.1 * place_m2 / (place_m2 + 0.0025), 0.05);
  EXPECT_NEAR(measured.way_m(1.0), estimated.way_m(1.0), 1e-12);
  EXPECT_GT(measured.way_m(1.0), 10.0);
}

TEST(WayFilter, IsContradictedByThreeStandardDeviationsOfBoth) {
  WayFilter filter = known_filter();
  filter.predict(kStep_s);
  const double place_m2 = filter.sigma_m() * filter.sigma_m();
  const double both_m = std::sqrt(place_m2 + 0.0004);
  const double share = place_m2 / (both_m * both_m);
  EXPECT_FALSE(filter.is_contradicted(share * 2.9 * both_m, 0.02));
  EXPECT_TRUE(filter.is_contradicted(-share * 3.1 * both_m, 0.02));
}

TEST(WayFilter, FewSurfacesChangeTheMeasuredSpeedByATenthAtMost) {
  WayFilter filter = known_filter();
  filter.predict(kStep_s);
  EXPECT_FALSE(filter.take_estimate(0.03, 0.06));
  bool is_held_back = false;
  for (int i = 0; i < 100; ++i) {
    filter.predict(kStep_s);
    is_held_back = filter.take_estimate(0.03, 0.06);
  }
  EXPECT_NEAR(filter.way_m(kStep_s), 1.1, 1e-9);
  EXPECT_TRUE(is_held_back) << "surfaces show another speed";
}

TEST(WayFilter, OfAVehicleThatStandsFollowsItWhenItStarts) {
  WayFilter filter;
  filter.begin(0.0);
  double ahead_m = 0.0;
  for (int i = 0; i < 40; ++i) {
    filter.predict(kStep_s);
    ahead_m = 0.02 * i - filter.way_m(kStep_s);
    filter.take_measurement(ahead_m, 0.01);
  }
  EXPECT_LT(std::abs(ahead_m), 0.06) << "at 7.8 m/s and 2 m/s2";
}

}  // namespace
}  // namespace sightline
