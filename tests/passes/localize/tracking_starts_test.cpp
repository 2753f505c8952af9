#include "passes/localize/tracking_starts.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

#include "formats/base/units.h"

namespace sightline {
namespace {

std::array<double, 4> in_deviations(const InitialOffset& offset, const TrackingPattern& pattern) {
  return {offset.x_m / pattern.horizontal_m, offset.y_m / pattern.horizontal_m,
          offset.z_m / pattern.height_m, offset.yaw_rad / (pattern.yaw_deg * kRadPerDeg)};
}

TEST(TrackingStarts, HaveMeanZeroTheirDeviationsAndUncorrelatedAxes) {
  for (const int count : {5, 6, 8, 12}) {
    TrackingPattern pattern;
    pattern.count = count;
    const std::vector<InitialOffset> starts = tracking_offsets(pattern);
    ASSERT_EQ(starts.size(), static_cast<std::size_t>(count));
    for (std::size_t a = 0; a < 4; ++a) {
      double mean = 0.0;
      for (const InitialOffset& start : starts) mean += in_deviations(start, pattern)[a] / count;
      EXPECT_NEAR(mean, 0.0, 1e-14);
      for (std::size_t b = 0; b < 4; ++b) {
        double moment = 0.0;
        for (const InitialOffset& start : starts) {
          const std::array<double, 4> axes = in_deviations(start, pattern);
          moment += axes[a] * axes[b] / count;
        }
        EXPECT_NEAR(moment, a == b ? 1.0 : 0.0, 1e-14) << count << " starts, axes " << a << b;
      }
    }
  }
}

TEST(TrackingStarts, AreFiveFifthsOfATurnApartTwentyCentimetresOff) {
  const std::vector<InitialOffset> starts = tracking_offsets(TrackingPattern{});
  ASSERT_EQ(starts.size(), 5U);
  for (const InitialOffset& start : starts) {
    EXPECT_NEAR(std::hypot(start.x_m, start.y_m), std::sqrt(2.0) * 0.141, 1e-15);
  }
  EXPECT_NEAR(starts[1].y_m / starts[1].x_m, std::tan(72.0 * kRadPerDeg), 1e-13);
  EXPECT_NEAR(starts[0].yaw_rad, std::sqrt(2.0) * 0.5 * kRadPerDeg, 1e-15);
  EXPECT_EQ(starts[0].z_m, 0.0);
}

TEST(TrackingStarts, HaveTheCovarianceThatTheMatcherIsGiven) {
  TrackingPattern pattern;
  pattern.horizontal_m = 0.2;
  pattern.height_m = 0.07;
  Eigen::Matrix3d axes;
  axes << 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;  // up is the map's x
  const Matrix6d covariance = tracking_covariance(pattern, axes);
  EXPECT_NEAR(covariance(0, 0), 0.07 * 0.07, 1e-15);
  EXPECT_NEAR(covariance(1, 1), 0.2 * 0.2, 1e-15);
  EXPECT_NEAR(covariance(2, 2), 0.2 * 0.2, 1e-15);
  for (int i = 3; i < 6; ++i) {
    EXPECT_NEAR(covariance(i, i), 0.5 * kRadPerDeg * 0.5 * kRadPerDeg, 1e-15);
  }
  EXPECT_EQ(covariance, covariance.transpose());
}

TEST(TrackingStarts, MayBeNoneAndAreNoFewerThanFive) {
  TrackingPattern pattern;
  pattern.count = 0;
  EXPECT_TRUE(validate(pattern).has_value());
  EXPECT_TRUE(tracking_offsets(pattern).empty());
  for (pattern.count = 1; pattern.count < 5; ++pattern.count) {
    EXPECT_EQ(validate(pattern).error().code, ErrorCode::kBadValue);
  }
  EXPECT_TRUE(validate(pattern).has_value());
}

}  // namespace
}  // namespace sightline
