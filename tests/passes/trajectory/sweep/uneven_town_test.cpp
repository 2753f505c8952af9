#include "tests/passes/trajectory/sweep/uneven_town.h"

#include <gtest/gtest.h>

#include "passes/trajectory/undistort_scans.h"

namespace sightline {
namespace {

TEST(UndistortUnevenTown, HasItsPointsNearerToTheTruthWithTurnRates) {
  UnevenTown town;
  PassContext ctx;
  const Result<Drive> even = undistort_scans(ctx, {}, town.recorded, town.given);
  town.recorded.turn_rates = town::imu_of(town.drive, 5);
  std::string said;
  ctx.warning_sink = [&](const std::string& message) { said += message + "\n"; };
  const Result<Drive> turned = undistort_scans(ctx, {}, town.recorded, town.given);
  ASSERT_TRUE(even.has_value() && turned.has_value());
  EXPECT_NE(said.find("turn rates are used"), std::string::npos) << said;
  const double even_m = error_m(town, *even);
  const double turned_m = error_m(town, *turned);
  RecordProperty("even_mm", static_cast<int>(1e3 * even_m));
  RecordProperty("turned_mm", static_cast<int>(1e3 * turned_m));
  EXPECT_GT(even_m, 0.05);
  EXPECT_LT(turned_m, 0.25 * even_m) << even_m;
}

}  // namespace
}  // namespace sightline
