#include "passes/trajectory/align_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

#include "passes/map/build_ndt.h"
#include "tests/support/box_world.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

struct Place {
  NdtMap map;
  Sites sites;
};

Place mapped(const BoxWorld& world) {
  Place place;
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 12; ++i) {
    const Pose T_map_lidar = lidar_at(1.5 * i, 0.0, 0.0);
    for (const Eigen::Vector3d& point_m : scan_world(world, T_map_lidar, 0.5).points_m) {
      points_m.push_back(T_map_lidar * point_m);
    }
    Site site;
    site.s_m = 1.5 * i;
    site.T_map_vehicle = pose_at(1.5 * i, 0.0, 0.0);
    site.p_map_m = T_map_lidar.translation();
    place.sites.sites.push_back(site);
  }
  place.map = ndt_from_points(points_m, MapFrame{}, {}, 1);
  return place;
}

TestDrive second_drive(const BoxWorld& world, bool turns) {
  std::vector<Pose> poses;
  for (int i = 0; i < 6; ++i) {
    const double x_m = turns ? 13.0 - 1.2 * i : 2.0 + 1.2 * i;
    poses.push_back(pose_at(x_m, -0.4, turns ? std::numbers::pi : 0.03));
  }
  return drive_through(world, poses, 0.5);
}

Trajectory own_trajectory(const TestDrive& drive) {
  Trajectory own = drive.truth;
  own.source = PoseSource::kEstimated;
  const Pose T_first_map = drive.truth.poses[0].T_map_vehicle.inverse();
  for (TrajectoryPose& pose : own.poses) pose.T_map_vehicle = T_first_map * pose.T_map_vehicle;
  return own;
}

TEST(AlignDrive, FindsAgainWhatItFoundInTheSameMap) {
  const BoxWorld world = random_street(20);
  const Place place = mapped(world);
  const TestDrive drive = second_drive(world, false);
  const Trajectory own = own_trajectory(drive);
  KeptParts kept;
  const auto aligned = [&](const Drive& second, const Trajectory& poses, const Place& in) {
    PassContext ctx = kept.context();
    return to_bytes(*align_drive(ctx, {}, second, poses, in.map, in.sites));
  };
  const std::vector<std::byte> first = aligned(drive.drive, own, place);
  EXPECT_EQ(kept.made().size(), 1U);
  Drive renamed = drive.drive;
  renamed.name = "another";
  EXPECT_EQ(aligned(renamed, own, place), first);
  EXPECT_TRUE(kept.made().empty());
  Place other = place;
  other.map.nds.back().mean_m.z() += 0.001;
  aligned(drive.drive, own, other);
  EXPECT_EQ(kept.made().size(), 1U);
  other = place;
  other.sites.sites.pop_back();
  aligned(drive.drive, own, other);
  EXPECT_EQ(kept.made().size(), 1U);
  Trajectory moved = own;
  moved.poses.back().T_map_vehicle.translation().x() += 0.001;
  aligned(drive.drive, moved, place);
  EXPECT_EQ(kept.made().size(), 1U);
}

TEST(AlignDrive, FindsASecondDriveInTheMapOfTheFirst) {
  for (const bool turns : {false, true}) {
    const BoxWorld world = random_street(turns ? 21 : 20);
    const Place place = mapped(world);
    const TestDrive drive = second_drive(world, turns);
    const Trajectory found = value_of(
        align_drive(TestContext(), {}, drive.drive, own_trajectory(drive), place.map, place.sites));
    EXPECT_TRUE(validate(found).has_value());
    EXPECT_EQ(found.source, PoseSource::kEstimated) << "a match to the map";
    for (std::size_t k = 0; k < drive.truth.poses.size(); ++k) {
      const Pose off = drive.truth.poses[k].T_map_vehicle.inverse() * found.poses[k].T_map_vehicle;
      // Cells of 2 m and exact rings: no sensor is as regular.
      EXPECT_LT(off.translation().norm(), 0.1) << turns << " scan " << k;
    }
  }
}

// Its errors would be those of no vehicle whose sensor is right.
TEST(AlignDrive, WarnsOfADriveThatMeasuresOtherDistancesThanTheMap) {
  const BoxWorld world = random_street(20);
  const Place place = mapped(world);
  for (const double scale : {1.0, 1.001, 1.01, 0.99}) {
    const TestDrive drive = scaled(second_drive(world, false), scale);
    KeptParts kept;
    for (const bool is_found_again : {false, true}) {
      PassContext ctx = kept.context();
      std::vector<std::string> warnings;
      ctx.warning_sink = [&](const std::string& message) { warnings.push_back(message); };
      ASSERT_TRUE(align_drive(ctx, {}, drive.drive, own_trajectory(drive), place.map, place.sites));
      EXPECT_EQ(kept.made().empty(), is_found_again);
      if (std::abs(scale - 1.0) < 0.002) {
        EXPECT_TRUE(warnings.empty()) << scale << ": " << warnings.front();
        continue;
      }
      ASSERT_EQ(warnings.size(), 1U) << scale;
      const char* text = scale > 1.0 ? "distances 1.0 % longer than in the map"
                                     : "distances 1.0 % shorter than in the map";
      EXPECT_NE(warnings[0].find(text), std::string::npos) << warnings[0];
    }
  }
}

TEST(AlignDrive, LeavesGivenPosesUnlessAskedToAlignThem) {
  const BoxWorld world = random_street(22);
  const Place place = mapped(world);
  const TestDrive drive = second_drive(world, false);
  Trajectory given = drive.truth;
  for (TrajectoryPose& pose : given.poses) pose.T_map_vehicle.translation().y() += 0.4;
  const Trajectory kept =
      value_of(align_drive(TestContext(), {}, drive.drive, given, place.map, place.sites));
  EXPECT_EQ(to_bytes(kept), to_bytes(given));
  const AlignDriveOptions options{.mode = AlignMode::kAlign};
  const Trajectory aligned =
      value_of(align_drive(TestContext(), options, drive.drive, given, place.map, place.sites));
  EXPECT_NEAR(aligned.poses[3].T_map_vehicle.translation().y(), -0.4, 0.05);
}

Trajectory given_poses(const TestDrive& drive, const Eigen::Vector3d& offset_m, double noise_m) {
  Random random(5);
  Trajectory given = drive.truth;
  for (TrajectoryPose& pose : given.poses) {
    const Eigen::Vector3d noise(random.normal(), random.normal(), 0.0);
    pose.T_map_vehicle.translation() += offset_m + noise_m * noise;
  }
  return given;
}

TEST(AlignDrive, NamesNoOffsetOfPosesWithNoise) {
  const BoxWorld world = random_street(20);
  const Place place = mapped(world);
  const TestDrive drive = second_drive(world, false);
  TestContext ctx;
  const Trajectory given = given_poses(drive, Eigen::Vector3d::Zero(), 0.02);
  ASSERT_TRUE(align_drive(ctx, {}, drive.drive, given, place.map, place.sites));
  EXPECT_THAT(ctx.warnings, testing::IsEmpty());
}

// Parts of its scans match any street.
TEST(AlignDrive, RefusesADriveOfAnotherStreet) {
  const Place place = mapped(random_street(23));
  const TestDrive drive = second_drive(random_street(99), false);
  for (const bool has_poses : {true, false}) {
    const Trajectory own = has_poses ? drive.truth : own_trajectory(drive);
    const Error error =
        failure_of(align_drive(TestContext(), {}, drive.drive, own, place.map, place.sites));
    EXPECT_EQ(error.code, ErrorCode::kNoOverlap);
    if (has_poses) {
      EXPECT_THAT(error.message, testing::HasSubstr("does not show this map: 0 of 6"));
    }
  }
}

// One of several drives is moved beyond every site instead.
TEST(AlignDrive, SeparatesALaterDriveThatMatchesNowhere) {
  const Place place = mapped(random_street(23));
  TestDrive drive = second_drive(random_street(99), false);
  drive.drive.store = memory_scan_store(std::vector<Scan>(6, {0, {{40.0, 40.0, 40.0}}}));
  TestContext ctx;
  const AlignDriveOptions options{.may_be_elsewhere = true};
  const Trajectory aside = value_of(
      align_drive(ctx, options, drive.drive, own_trajectory(drive), place.map, place.sites));
  ASSERT_TRUE(validate(aside).has_value());
  ASSERT_EQ(aside.poses.size(), drive.drive.scans.size());
  for (const TrajectoryPose& pose : aside.poses) {
    for (const Site& site : place.sites.sites) {
      EXPECT_GT((pose.T_map_vehicle.translation() - site.p_map_m).norm(), 1000.0);
    }
  }
  EXPECT_THAT(ctx.warnings, testing::ElementsAre(testing::HasSubstr("does not match the map")));
}

TEST(AlignDrive, RefusesADriveThatMatchesNowhere) {
  const Place place = mapped(random_street(23));
  TestDrive drive = second_drive(random_street(99), false);
  drive.drive.store = memory_scan_store(std::vector<Scan>(6, {0, {{40.0, 40.0, 40.0}}}));
  const auto refused = [&](const Trajectory& own, const NdtMap& map) {
    return failure_of(align_drive(TestContext(), {}, drive.drive, own, map, place.sites)).code;
  };
  EXPECT_EQ(refused(own_trajectory(drive), place.map), ErrorCode::kNoOverlap);
  Trajectory shorter = own_trajectory(drive);
  shorter.poses.pop_back();
  EXPECT_EQ(refused(shorter, place.map), ErrorCode::kMismatchedInputs);
  EXPECT_EQ(refused(own_trajectory(drive), NdtMap{}), ErrorCode::kEmptyMap);
}

}  // namespace
}  // namespace sightline
