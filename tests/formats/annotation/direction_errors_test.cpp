#include "formats/annotation/direction_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

TEST(DirectionErrors, AreMeanDeviationAndSlopeByHand) {
  const std::vector<InitialOffset> starts = {{-1.0, 0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  const std::vector<AxisErrors> ends = {{0.25F, -0.5F, 0.0F, 0.0F}, {0.75F, 0.0F, 0.125F, 0.0F}};
  const DirectionErrors errors = direction_errors(starts, ends);
  EXPECT_EQ(errors.mean, (AxisErrors{0.5F, -0.25F, 0.0625F, 0.0F}));
  EXPECT_EQ(errors.deviation, (AxisErrors{0.25F, 0.25F, 0.0625F, 0.0F}));
  EXPECT_EQ(errors.kept.longitudinal_m, 0.25F) << "ends differ by 0.5 m, starts by 2 m";
  EXPECT_EQ(errors.kept.lateral_m, 0.0F) << "the starts do not differ on this axis";
  EXPECT_EQ(direction_errors({}, {}).deviation, AxisErrors());
}

TEST(DirectionErrors, KeepTheShareThatEndsWereMadeWith) {
  Random random(7);
  std::vector<InitialOffset> starts;
  std::vector<AxisErrors> ends;
  for (int i = 0; i < 2000; ++i) {
    const InitialOffset start{random.normal(), random.normal(), random.normal(), random.normal()};
    starts.push_back(start);
    ends.push_back({static_cast<float>(0.1 + 0.6 * start.x_m + 0.1 * random.normal()),
                    static_cast<float>(0.02 * random.normal()), static_cast<float>(start.z_m),
                    static_cast<float>(-0.3 * start.yaw_rad)});
  }
  const DirectionErrors errors = direction_errors(starts, ends);
  EXPECT_NEAR(errors.kept.longitudinal_m, 0.6, 0.01);
  EXPECT_NEAR(errors.kept.lateral_m, 0.0, 0.002);
  EXPECT_NEAR(errors.kept.height_m, 1.0, 1e-6);
  EXPECT_NEAR(errors.kept.yaw_rad, -0.3, 1e-6);
  EXPECT_NEAR(errors.mean.longitudinal_m, 0.1, 0.06) << "2000 starts, of deviation 1";
  EXPECT_NEAR(errors.deviation.longitudinal_m, std::hypot(0.6, 0.1), 0.02);
}

}  // namespace
}  // namespace sightline
