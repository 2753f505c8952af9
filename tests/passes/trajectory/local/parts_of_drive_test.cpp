#include "passes/trajectory/local/parts_of_drive.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "passes/ingest/join_drives.h"
#include "passes/trajectory/estimate_undistorted.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/undistort_scans.h"
#include "tests/support/swept_world.h"
#include "tests/support/test_context.h"

// Drives of several vehicles in one map: how the scans of one were measured is decided by its own
// scans.

namespace sightline {
namespace {

TestDrive named(TestDrive test, const std::string& name) {
  test.drive.name = name;
  return test;
}

TestDrive street(double sweep_s, int scans) {
  std::vector<double> times_s;
  for (int i = 0; i < scans; ++i) times_s.push_back(0.1 * i);
  return drive_swept(random_street(2), winding(-14.0, 10.0), times_s, PointOrder::kTime, sweep_s);
}

TestDrive joined(const std::vector<TestDrive>& tests) {
  TestDrive all = tests.front();
  for (std::size_t i = 1; i < tests.size(); ++i) {
    all.drive = *join_drives(TestContext(), {}, all.drive, {{&tests[i].drive}});
    for (const TrajectoryPose& pose : tests[i].truth.poses) {
      const std::size_t number = all.truth.poses.size();
      all.truth.poses.push_back({all.drive.scans[number].recording_index,
                                 all.drive.scans[number].stamp_ns, pose.T_map_vehicle});
    }
  }
  return all;
}

double farthest_m(const Drive& a, std::size_t first_a, const Drive& b, std::size_t first_b,
                  std::size_t count) {
  double most_m = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Scan of_a = *a.store->read(first_a + i);
    const Scan of_b = *b.store->read(first_b + i);
    EXPECT_EQ(of_a.points_m.size(), of_b.points_m.size());
    for (std::size_t k = 0; k < of_a.points_m.size(); ++k) {
      most_m = std::max(most_m, (of_a.points_m[k] - of_b.points_m[k]).norm());
    }
  }
  return most_m;
}

TEST(PartsOfDrive, AreTheDrivesThatWereJoined) {
  std::vector<TestDrive> days = {named(street(0.1, 4), "mon"), named(street(0.1, 3), "tue"),
                                 named(street(0.1, 5), "wed")};
  days[0].drive.turn_rates = {{0, Eigen::Vector3d::Zero()}, {300'000'000, Eigen::Vector3d::Zero()}};
  days[2].drive.turn_rates = {{-10'000'000, Eigen::Vector3d::Zero()},
                              {900'000'000, Eigen::Vector3d::Zero()}};
  const TestDrive all = joined(days);
  const std::vector<Drive> parts = parts_of(all.drive);
  ASSERT_EQ(parts.size(), 3u);
  const std::vector<Trajectory> poses = trajectories_of_parts(parts, all.truth);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(parts[i].name, days[i].drive.name);
    EXPECT_TRUE(validate(parts[i]).has_value());
    EXPECT_EQ(parts[i].turn_rates.size(), days[i].drive.turn_rates.size());
    ASSERT_EQ(parts[i].scans.size(), days[i].drive.scans.size());
    ASSERT_EQ(poses[i].poses.size(), days[i].drive.scans.size());
    EXPECT_EQ(poses[i].poses[0].stamp_ns, parts[i].scans[0].stamp_ns);
    EXPECT_EQ(farthest_m(parts[i], 0, days[i].drive, 0, parts[i].scans.size()), 0.0);
  }
}

class NamedStore : public ScanStore {
 public:
  explicit NamedStore(std::shared_ptr<const ScanStore> store) : store_(std::move(store)) {}
  Result<Scan> read(std::size_t index) const override { return store_->read(index); }
  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    return sha256("scan " + std::to_string(index));
  }

 private:
  std::shared_ptr<const ScanStore> store_;
};

TEST(PartsOfDrive, AreJoinedAgainScanByScan) {
  TestDrive all = joined({named(street(0.1, 4), "mon"), named(street(0.1, 3), "tue")});
  all.drive = with_store(all.drive, std::make_shared<const NamedStore>(all.drive.store));
  std::vector<Drive> parts = parts_of(all.drive);
  for (ScanInfo& scan : parts[1].scans) scan.has_point_times = true;
  parts[1].turn_rates = {{parts[1].scans[0].stamp_ns, Eigen::Vector3d::Zero()}};
  const Drive again = joined_again(all.drive, parts);
  ASSERT_TRUE(validate(again).has_value());
  EXPECT_EQ(farthest_m(again, 0, all.drive, 0, 7), 0.0);
  EXPECT_EQ(again.turn_rates.size(), 1u);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(again.scans[i].part, all.drive.scans[i].part);
    EXPECT_EQ(again.scans[i].has_point_times, i >= 4);
    EXPECT_EQ(again.store->identity(i), sha256("scan " + std::to_string(i)));
  }
}

TEST(PartsOfDrive, OfOnePartAreTheDriveItself) {
  const TestDrive one = street(0.1, 3);
  const std::vector<Drive> parts = parts_of(one.drive);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].store, one.drive.store);
  EXPECT_EQ(joined_again(one.drive, parts).store, one.drive.store);
}

// The first drive is the longer one, and was undistorted before it came here.
TEST(UndistortScans, AsksEachDriveHowItsScansWereMeasured) {
  constexpr std::size_t kRigid = 16;
  constexpr std::size_t kSwept = 12;
  const TestDrive swept = street(0.1, kSwept);
  const TestDrive all = joined({street(0.0, kRigid), swept});
  const Drive straight = value_of(undistort_scans(TestContext(), {}, all.drive, all.truth));
  EXPECT_EQ(farthest_m(straight, 0, all.drive, 0, kRigid), 0.0);
  const Drive alone = value_of(undistort_scans(TestContext(), {}, swept.drive, swept.truth));
  EXPECT_GT(farthest_m(alone, 0, swept.drive, 0, kSwept), 0.4);
  EXPECT_EQ(farthest_m(straight, kRigid, alone, 0, kSwept), 0.0);
}

TEST(EstimateUndistorted, AsksEachDriveHowItsScansWereMeasured) {
  constexpr std::size_t kRigid = 16;
  constexpr std::size_t kSwept = 12;
  const TestDrive all = joined({street(0.0, kRigid), street(0.1, kSwept)});
  std::optional<Drive> last;  // of which poses were estimated
  const EstimatePoses estimate = [&](PassContext&, const Drive& drive) -> Result<Estimate> {
    last = drive;
    const Trajectory& truth = all.truth;
    Trajectory found;
    for (const ScanInfo& scan : drive.scans) {
      found.poses.push_back(
          *std::ranges::find(truth.poses, scan.recording_index, &TrajectoryPose::recording_index));
    }
    return Estimate{found};
  };
  ASSERT_TRUE(
      estimate_undistorted(TestContext(), all.drive, Estimate{all.truth}, estimate).has_value());
  ASSERT_TRUE(last.has_value());
  ASSERT_EQ(last->scans.size(), kRigid + kSwept);
  EXPECT_EQ(farthest_m(*last, 0, all.drive, 0, kRigid), 0.0);
  EXPECT_GT(farthest_m(*last, kRigid, all.drive, kRigid, kSwept), 0.4);
}

// 100 scans at a light, between two stretches of 50 on which the vehicle drives.
TEST(SweepTrial, TakesScansOnWhichTheVehicleComesOn) {
  std::vector<Scan> scans(200);
  std::vector<Pose> poses;
  double at_m = 0.0;
  for (int i = 0; i < 200; ++i) {
    if (i < 50 || i >= 150) at_m += 0.5;
    poses.push_back(pose_at(at_m, 0.0, 0.0));
  }
  const TestDrive test = drive_of(std::move(scans), poses);
  const Drive middle = middle_of(test.drive, test.truth);
  ASSERT_EQ(middle.scans.size(), 60u);
  // Ten steps of half a metre, the first of them from scan 149 to 150.
  EXPECT_EQ(middle.scans.front().recording_index, 100u);
  EXPECT_EQ(middle_of(test.truth).poses.front().recording_index, 100u);
  Trajectory standing = test.truth;
  for (TrajectoryPose& pose : standing.poses) pose.T_map_vehicle = poses.front();
  EXPECT_EQ(middle_of(test.drive, standing).scans.front().recording_index, 70u);
}

// Sharpness is no evidence where scans do not constrain the way.
TEST(SweepTrial, TakesScansThatAreConstrained) {
  std::vector<Pose> poses;
  for (int i = 0; i < 200; ++i) poses.push_back(pose_at(0.5 * i, 0.0, 0.0));
  const TestDrive test = drive_of(std::vector<Scan>(200), poses);
  EXPECT_EQ(middle_of(test.truth).poses.front().recording_index, 70u);
  Trajectory in_tunnel = test.truth;
  for (std::size_t i = 60; i < 140; ++i) in_tunnel.poses[i].unconstrained.along = true;
  EXPECT_EQ(middle_of(in_tunnel).poses.front().recording_index, 0u);
  EXPECT_EQ(middle_of(test.drive, in_tunnel).scans.front().recording_index, 0u);
  // No 60 scans in a row are constrained: those with the fewest that are not.
  for (std::size_t i = 50; i < 150; ++i) in_tunnel.poses[i].unconstrained.along = true;
  in_tunnel.poses[170].unconstrained.heading = true;
  EXPECT_EQ(middle_of(in_tunnel).poses.front().recording_index, 0u);
  for (TrajectoryPose& pose : in_tunnel.poses) pose.unconstrained.along = true;
  EXPECT_EQ(middle_of(in_tunnel).poses.front().recording_index, 70u);
}

}  // namespace
}  // namespace sightline
