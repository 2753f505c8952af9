#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <deque>
#include <numbers>

#include "examples/ros2/core/map_matcher.h"
#include "examples/ros2/core/odometry_localizer.h"
#include "examples/ros2/core/pose_buffer.h"
#include "examples/ros2/core/poses.h"
#include "examples/ros2/core/scan_matcher.h"
#include "examples/ros2/core/vehicle_axes.h"
#include "passes/replay/pose_rows.h"
#include "tests/examples/ros2_replay.h"
#include "tests/examples/ros2_street.h"
#include "tests/support/value_of.h"

// What the nodes of examples/ros2 do, without ROS.

namespace sightline_ros2 {
namespace {

using sightline::ros_street;
using sightline::Scan;
using sightline::value_of;
using ::testing::HasSubstr;

MatcherOptions of_street() {
  MatcherOptions options;
  options.map_file = ros_street().map_file;
  return options;
}

StampedPose at_s(double t_s, double x_m, double yaw_rad = 0.0) {
  StampedPose pose;
  pose.stamp_ns = std::llround(t_s * 1e9);
  pose.pose = {{x_m, 0.0, 0.0}, quaternion_of_yaw(yaw_rad)};
  return pose;
}

TEST(Ros2Poses, QuaternionsAndRowsAreTheSamePose) {
  for (const double yaw_rad : {0.0, 1.0, 3.0, -3.1}) {
    for (const std::array<double, 4>& tilt :
         {std::array<double, 4>{0, 0, 0, 1}, {0.6, 0, 0, 0.8}, {0, 1, 0, 0}, {1, 0, 0, 0}}) {
      const Pose pose{{1.0, 2.0, 3.0}, product(quaternion_of_yaw(yaw_rad), tilt)};
      const Pose again = pose_of(rows_of(pose));
      EXPECT_NEAR(turn_rad(pose, again), 0.0, 1e-7);
      EXPECT_EQ(again.position_m, pose.position_m);
      const PoseRows unit = product(rows_of(pose), inverse(rows_of(pose)));
      EXPECT_NEAR(unit[0], 1.0, 1e-12);
      EXPECT_NEAR(unit[3], 0.0, 1e-12);
    }
  }
}

TEST(Ros2Poses, AnInterpolatedPoseTurnsTheShorterWay) {
  const Pose from{{0.0, 0.0, 0.0}, quaternion_of_yaw(3.0)};
  const Pose to{{2.0, 0.0, 0.0}, quaternion_of_yaw(-3.0)};
  const Pose half = interpolated(from, to, 0.5);
  EXPECT_DOUBLE_EQ(half.position_m[0], 1.0);
  EXPECT_NEAR(turn_rad(half, {{}, quaternion_of_yaw(std::numbers::pi)}), 0.0, 1e-7);
}

TEST(Ros2PoseBuffer, InterpolatesBetweenTwoPosesAndFollowsThemAhead) {
  PoseBuffer buffer(1.0, 10.0);
  EXPECT_FALSE(buffer.at(0));
  buffer.add(at_s(1.0, 0.0));
  EXPECT_FALSE(buffer.at(1'000'000'000)) << "one pose";
  buffer.add(at_s(1.2, 2.0));
  buffer.add(at_s(1.4, 6.0));
  EXPECT_FALSE(buffer.at(900'000'000)) << "before all";
  EXPECT_DOUBLE_EQ(buffer.at(1'100'000'000)->pose.pose.position_m[0], 1.0);
  EXPECT_DOUBLE_EQ(buffer.at(1'300'000'000)->pose.pose.position_m[0], 4.0);
  const PoseAtTime ahead = *buffer.at(1'500'000'000);
  EXPECT_NEAR(ahead.pose.pose.position_m[0], 8.0, 1e-9);
  EXPECT_EQ(ahead.after.pose.position_m[0], 6.0);
  EXPECT_FALSE(buffer.at(2'300'000'000)) << "older than the timeout";
}

TEST(Ros2PoseBuffer, RefusesJumpsAndBeginsAgainWithARecording) {
  PoseBuffer buffer(1.0, 10.0);
  buffer.add(at_s(1.0, 0.0));
  buffer.add(at_s(1.1, 50.0));
  EXPECT_FALSE(buffer.at(1'050'000'000));
  buffer.add(at_s(0.5, 1.0));
  EXPECT_FALSE(buffer.at(1'000'000'000)) << "the buffer was emptied";
  buffer.add(at_s(0.5, 3.0));
  buffer.add(at_s(0.6, 4.0));
  EXPECT_EQ(buffer.at(500'000'000)->pose.pose.position_m[0], 3.0) << "of one time the last";
}

TEST(Ros2VehicleAxes, TurnsACovarianceWithTheVehicle) {
  Covariance of_vehicle{};
  of_vehicle[0] = 4.0;
  of_vehicle[7] = 1.0;
  const Pose north{{}, quaternion_of_yaw(std::numbers::pi / 2)};
  const Covariance of_map = in_map_axes(north, of_vehicle);
  EXPECT_NEAR(of_map[0], 1.0, 1e-12);
  EXPECT_NEAR(of_map[7], 4.0, 1e-12);
  const VehicleSigmas sigmas = sigmas_of(north, of_map);
  EXPECT_NEAR(sigmas.forward_m, 2.0, 1e-12);
  EXPECT_NEAR(sigmas.left_m, 1.0, 1e-12);
  EXPECT_EQ(names_of_weak(SIGHTLINE_WEAK_FORWARD | SIGHTLINE_WEAK_YAW), "forward, yaw");
  EXPECT_EQ(names_of_weak(0), "none");
}

class Ros2Core : public testing::Test {
 protected:
  Ros2Core() : matcher_(value_of(MapMatcher::open(of_street())), {}) {}

  [[nodiscard]] static Pose truth(std::size_t scan) {
    return pose_of(sightline::rows_of(ros_street().truth_map(scan)));
  }
  // Held by the test, as a node holds the message.
  IncomingScan scan(std::size_t number) {
    scans_.push_back(*ros_street().test.drive.store->read(number));
    IncomingScan incoming;
    incoming.stamp_ns = ros_street().test.truth.poses[number].stamp_ns;
    incoming.scan = {sightline::points_of(scans_.back()), matcher_.map().T_base_sensor()};
    return incoming;
  }
  // A filter whose pose is off by so much ahead.
  void give_pose(std::size_t scan, double ahead_m) {
    for (const int step : {-1, 0}) {
      StampedPose pose{
          ros_street().test.truth.poses[scan].stamp_ns + step * 50'000'000, truth(scan), {}};
      pose.pose.position_m[0] += ahead_m + 0.2 * step;
      for (std::size_t i = 0; i < 6; ++i) pose.covariance[7 * i] = i < 3 ? 0.09 : 4e-4;
      matcher_.add_initial_pose(pose, "map");
    }
  }
  [[nodiscard]] static std::string value(const Report& report, const std::string& key) {
    for (const auto& [name, text] : report.values) {
      if (name == key) return text;
    }
    return "none";
  }

  ScanMatcher matcher_;
  std::deque<Scan> scans_;
};

TEST_F(Ros2Core, MatchesFromThePoseOfTheFilter) {
  matcher_.trigger(true, 0);
  give_pose(12, -0.2);
  const IncomingScan incoming = scan(12);
  const ScanResult result = matcher_.take(incoming, incoming.stamp_ns);
  ASSERT_TRUE(result.is_converged) << result.report.message;
  EXPECT_LT(distance_m(result.match.pose.position_m, truth(12).position_m), 0.02);
  EXPECT_NEAR(result.distance_m, 0.2, 0.03);
  EXPECT_NEAR(result.distance_old_m, 0.2, 0.03);
  EXPECT_NEAR(result.initial_to_result.position_m[0], 0.2, 0.03);
  EXPECT_EQ(result.report.level, Level::kOk) << result.report.message;
  EXPECT_EQ(value(result.report, "integrity"), "ok");
  EXPECT_GT(std::stod(value(result.report, "nearest_voxel_transformation_likelihood_diff")), 0.0);
  EXPECT_GT(std::stod(value(result.report, "protection_left_m")), 0.0);
}

// A filter that supplied the start must not count it twice: the scan's own covariance is wider.
TEST_F(Ros2Core, PublishesThePoseOfTheScanAloneOrWithItsStart) {
  const auto taken = [&](CovarianceOf covariance_of) {
    ScanMatcherOptions options;
    options.covariance_of = covariance_of;
    options.output_pose_covariance[0] = 4.0;
    matcher_ = ScanMatcher(value_of(MapMatcher::open(of_street())), options);
    matcher_.trigger(true, 0);
    give_pose(12, -0.2);
    const IncomingScan incoming = scan(12);
    return matcher_.take(incoming, incoming.stamp_ns);
  };
  const ScanResult alone = taken(CovarianceOf::kScan);
  const ScanResult fused = taken(CovarianceOf::kPose);
  ASSERT_TRUE(alone.is_converged && fused.is_converged);
  EXPECT_EQ(alone.covariance, alone.match.covariance);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_GT(fused.covariance[7 * i], 0.0);
    EXPECT_GT(alone.covariance[7 * i], fused.covariance[7 * i]);
  }
  EXPECT_GT(distance_m(fused.match.pose.position_m, truth(12).position_m),
            distance_m(alone.match.pose.position_m, truth(12).position_m));
  EXPECT_EQ(value(alone.report, "protection_left_m"), value(fused.report, "protection_left_m"));
  EXPECT_NEAR(taken(CovarianceOf::kFixedValue).covariance[0], 4.0, 0.01);
}

TEST_F(Ros2Core, ReportsWhyAScanGivesNoPose) {
  const IncomingScan incoming = scan(3);
  const auto message_of = [&](const IncomingScan& taken) {
    const ScanResult result = matcher_.take(taken, incoming.stamp_ns);
    EXPECT_FALSE(result.is_matched);
    return result.report.message;
  };
  EXPECT_THAT(message_of(incoming), HasSubstr("not activated"));
  matcher_.trigger(true, 0);
  EXPECT_THAT(message_of(incoming), HasSubstr("ekf_pose_with_covariance"));
  IncomingScan empty = incoming;
  empty.scan.points.count = 0;
  EXPECT_THAT(message_of(empty), HasSubstr("no points"));
  IncomingScan untransformed = incoming;
  untransformed.transform_fault = "No transform";
  EXPECT_THAT(message_of(untransformed), HasSubstr("No transform"));
  give_pose(3, 5000.0);
  EXPECT_THAT(message_of(incoming), HasSubstr("nothing near"));
}

TEST_F(Ros2Core, CountsScansWithoutAPose) {
  matcher_.trigger(true, 0);
  const IncomingScan incoming = scan(3);
  for (int i = 1; i <= 5; ++i) {
    const ScanResult result = matcher_.take(incoming, incoming.stamp_ns);
    EXPECT_EQ(value(result.report, "skipping_publish_num"), std::to_string(i));
    EXPECT_EQ(result.report.message.find("in a row") != std::string::npos, i == 5);
  }
}

TEST_F(Ros2Core, RefusesPosesOfAnotherFrame) {
  matcher_.trigger(true, 0);
  EXPECT_EQ(matcher_.add_initial_pose(at_s(1.0, 0.0), "odom").level, Level::kError);
  matcher_.trigger(false, 0);
  EXPECT_EQ(matcher_.add_initial_pose(at_s(1.0, 0.0), "map").level, Level::kWarn);
}

TEST_F(Ros2Core, FindsTheVehicleAtAnyHeadingWithinTwoMetres) {
  const IncomingScan incoming = scan(10);
  EXPECT_FALSE(matcher_.align(StampedPose(), "", 0).is_success) << "no scan yet";
  matcher_.take(incoming, incoming.stamp_ns);
  StampedPose start{0, truth(10), {}};
  start.pose.position_m[0] += 1.1;
  start.pose.position_m[1] -= 0.6;
  start.pose.quaternion_xyzw = quaternion_of_yaw(2.0);
  start.covariance[0] = start.covariance[7] = 1.0;
  const AlignResult result = matcher_.align(start, "", 0);
  ASSERT_TRUE(result.is_success) << result.report.message;
  EXPECT_TRUE(result.is_reliable) << result.report.message;
  EXPECT_LT(distance_m(result.pose.pose.position_m, truth(10).position_m), 0.02);
  EXPECT_LT(turn_rad(result.pose.pose, truth(10)), 0.01);
  const AlignResult untransformed = matcher_.align(std::nullopt, "No transform", 0);
  EXPECT_EQ(untransformed.report.level, Level::kError);
}

TEST_F(Ros2Core, FarFromTheRightPlaceItIsNotReliable) {
  const IncomingScan incoming = scan(10);
  matcher_.take(incoming, incoming.stamp_ns);
  StampedPose start{0, truth(10), {}};
  start.pose.position_m[0] += 9.0;
  EXPECT_FALSE(matcher_.align(start, "", 0).is_reliable);
}

TEST_F(Ros2Core, ScoresWithoutGroundAreOfPointsAboveTheMargin) {
  ScanMatcherOptions options;
  options.has_no_ground_score = true;
  matcher_ = ScanMatcher(value_of(MapMatcher::open(of_street())), options);
  matcher_.trigger(true, 0);
  give_pose(3, 0.1);
  const IncomingScan incoming = scan(3);
  const ScanResult result = matcher_.take(incoming, incoming.stamp_ns);
  ASSERT_TRUE(result.no_ground);
  EXPECT_GT(result.no_ground->nearest_voxel_likelihood, 1.0);
  ASSERT_FALSE(result.no_ground->points_base_m.empty());
  EXPECT_LT(result.no_ground->points_base_m.size(), 3 * incoming.scan.points.count);
  for (std::size_t i = 2; i < result.no_ground->points_base_m.size(); i += 3) {
    EXPECT_GT(result.no_ground->points_base_m[i], 0.75);
  }
}

// Clouds that were moved to the vehicle's frame give the pose of the sensor's cloud.
TEST_F(Ros2Core, PointsMayBeInTheVehiclesFrame) {
  matcher_.trigger(true, 0);
  give_pose(3, 0.3);
  IncomingScan incoming = scan(3);
  const ScanResult in_sensor = matcher_.take(incoming, incoming.stamp_ns);
  for (Eigen::Vector3d& point_m : scans_.back().points_m) point_m.z() += 2.0;
  incoming.scan.T_base_points = rows_of(Pose());
  const ScanResult in_base = matcher_.take(incoming, incoming.stamp_ns);
  ASSERT_TRUE(in_base.is_converged);
  EXPECT_LT(distance_m(in_base.match.pose.position_m, in_sensor.match.pose.position_m), 1e-3);
}

TEST_F(Ros2Core, AWrongPlaceIsLostAfterSomeScans) {
  matcher_.trigger(true, 0);
  // Scans of the far end of the street at its beginning.
  bool is_lost = false;
  for (std::size_t i = 0; i < 12 && !is_lost; ++i) {
    give_pose(i, 0.0);
    IncomingScan incoming = scan(23 - i);
    incoming.stamp_ns = ros_street().test.truth.poses[i].stamp_ns;
    const ScanResult result = matcher_.take(incoming, incoming.stamp_ns);
    is_lost = !result.is_converged;
  }
  EXPECT_TRUE(is_lost);
}

TEST(Ros2Odometry, FollowsOdometryThatDrifts) {
  const std::size_t count = ros_street().test.truth.poses.size();
  OdometryLocalizer localizer(value_of(MapMatcher::open(of_street())), {});
  const auto scan_of = [&](std::size_t i) { return *ros_street().test.drive.store->read(i); };
  const auto odometry = [](std::size_t i) {
    return rows_of(Pose{{0.42 * static_cast<double>(i), 0.0, 0.0}, {0, 0, 0, 1}});
  };
  const Scan first = scan_of(0);
  const PoseRows T_base_sensor = localizer.map().T_base_sensor();
  EXPECT_FALSE(
      localizer.take(0, {sightline::points_of(first), T_base_sensor}, odometry(0)).has_pose);
  StampedPose initial{0, pose_of(sightline::rows_of(ros_street().truth_map(0))), {}};
  initial.pose.position_m[0] += 0.8;
  initial.pose.position_m[2] = 0.0;  // as RViz gives it
  initial.covariance[0] = initial.covariance[7] = 0.25;
  localizer.set_initial_pose(initial);
  for (std::size_t i = 0; i < count; ++i) {
    const Scan scan = scan_of(i);
    const TrackedScan result = localizer.take(
        static_cast<std::int64_t>(i), {sightline::points_of(scan), T_base_sensor}, odometry(i));
    ASSERT_TRUE(result.has_pose) << i << " " << result.report.message;
    const Pose truth = pose_of(sightline::rows_of(ros_street().truth_map(i)));
    EXPECT_LT(distance_m(result.match.pose.position_m, truth.position_m), 0.03) << i;
    const PoseRows again = product(result.T_map_odom, odometry(i));
    EXPECT_NEAR(again[3], result.match.pose.position_m[0], 1e-6);
  }
  EXPECT_EQ(localizer.state(), TrackState::kTracking);
}

TEST(Ros2Replay, StreamedAndWholeGiveTheSameBitsAndTheTruth) {
  const sightline::RosStreet& street = ros_street();
  sightline::NodeReplayOptions options;
  options.map_file = street.map_file;
  options.T_world_start = street.truth_world(0);
  const auto replay = [&] {
    return value_of(replay_in_node(options, *street.test.drive.store, street.listed(),
                                   street.test.drive.sensor));
  };
  const std::vector<sightline::NodeScan> streamed = replay();
  options.holds_whole_map = true;
  const std::vector<sightline::NodeScan> whole = replay();
  ASSERT_EQ(streamed.size(), street.test.truth.poses.size());
  for (std::size_t i = 0; i < streamed.size(); ++i) {
    ASSERT_TRUE(streamed[i].has_pose) << i << " " << streamed[i].message;
    EXPECT_EQ(std::memcmp(&streamed[i].match, &whole[i].match, sizeof whole[i].match), 0) << i;
    EXPECT_LT(
        (streamed[i].T_world_vehicle.translation() - street.truth_world(i).translation()).norm(),
        0.03)
        << i;
  }
}

}  // namespace
}  // namespace sightline_ros2
