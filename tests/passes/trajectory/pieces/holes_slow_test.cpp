// A recording that lacks scans where the vehicle turns. Scans are drawn out by how it turned while
// they were measured, otherwise before the hole than behind it: matched as they are they lie askew.

#include <gtest/gtest.h>

#include "formats/geometry.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "tests/support/swept_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

struct Off {
  double largest_m = 0.0;
  double largest_deg = 0.0;
};

Off off_truth(const Trajectory& found, const Trajectory& truth) {
  Off off;
  const Pose T_truth_found =
      truth.poses.front().T_map_vehicle * found.poses.front().T_map_vehicle.inverse();
  for (std::size_t i = 0; i < truth.poses.size(); ++i) {
    const Pose between =
        truth.poses[i].T_map_vehicle.inverse() * T_truth_found * found.poses[i].T_map_vehicle;
    off.largest_m = std::max(off.largest_m, between.translation().norm());
    off.largest_deg =
        std::max(off.largest_deg, rotation_angle_rad(between.linear()) * 180.0 / std::numbers::pi);
  }
  return off;
}

TEST(Holes, LeaveTheWayBehindThemWhereItIsThoughScansAreDrawnOut) {
  std::vector<double> times_s;
  for (int i = 0; i < 30; ++i)
    if (i < 10 || i >= 18) times_s.push_back(0.1 * i);
  for (const PointOrder order : {PointOrder::kTime, PointOrder::kRings}) {
    for (const bool has_stamps : {false, true}) {
      TestDrive test = drive_swept(random_street(1), winding(-14.0, 10.0), times_s, order);
      if (has_stamps) {
        std::vector<Scan> scans = scans_of(test.drive);
        for (std::size_t i = 0; i < times_s.size(); ++i) {
          scans[i].stamp_ns = std::llround(1e9 * times_s[i]);
          test.drive.scans[i].stamp_ns = test.truth.poses[i].stamp_ns = scans[i].stamp_ns;
        }
        test.drive.store = memory_scan_store(scans);
      }
      const Trajectory found = value_of(estimate_trajectory(TestContext(2), {}, test.drive));
      EXPECT_EQ(found.poses.back().piece, 0u);
      const Off off = off_truth(found, test.truth);
      EXPECT_LT(off.largest_m, 0.15) << (order == PointOrder::kTime) << has_stamps;
      EXPECT_LT(off.largest_deg, 0.3) << (order == PointOrder::kTime) << has_stamps;
    }
  }
}

}  // namespace
}  // namespace sightline
