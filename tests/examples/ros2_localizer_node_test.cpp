#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "examples/ros2/src/localizer_node.h"
#include "examples/ros2/src/messages.h"
#include "examples/ros2/src/nav2_node.h"
#include "passes/replay/pose_rows.h"
#include "tests/examples/ros2_street.h"

// The nodes that localize, over headers that tests/examples/ros2_headers.py makes: what they
// publish, send and answer.

namespace sightline_ros2 {
namespace {

using autoware_internal_debug_msgs::msg::Float32Stamped;
using Align = autoware_internal_localization_msgs::srv::PoseWithCovarianceStamped;
using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::PoseStamped;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using sensor_msgs::msg::PointCloud2;
using sightline::ros_street;
using std_srvs::srv::SetBool;
using ::testing::HasSubstr;
using Points = std::shared_ptr<PointCloud2>;

Pose truth(std::size_t scan) { return pose_of(sightline::rows_of(ros_street().truth_map(scan))); }
std::int64_t stamp_ns(std::size_t scan) {
  return 100'000'000'000 + ros_street().test.truth.poses[scan].stamp_ns;
}

// Of the frame of the sensor, with an intensity between the points.
Points cloud(std::size_t scan, std::size_t of_scan) {
  const auto message = std::make_shared<PointCloud2>();
  message->header.frame_id = "lidar";
  message->header.stamp = time_of(stamp_ns(scan));
  message->height = 1;
  message->point_step = 20;
  for (const auto& [name, offset] : {std::pair("x", 4U), {"y", 8U}, {"z", 12U}, {"i", 16U}}) {
    sensor_msgs::msg::PointField field;
    field.name = name;
    field.offset = offset;
    field.datatype = sensor_msgs::msg::PointField::FLOAT32;
    message->fields.push_back(field);
  }
  const sightline::Scan points = *ros_street().test.drive.store->read(of_scan);
  for (const Eigen::Vector3d& point_m : points.points_m) {
    float numbers[5] = {-1.0F, 0.0F, 0.0F, 0.0F, 7.0F};
    for (int i = 0; i < 3; ++i) numbers[i + 1] = static_cast<float>(point_m[i]);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(numbers);
    message->data.insert(message->data.end(), bytes, bytes + sizeof numbers);
  }
  message->width = static_cast<std::uint32_t>(points.points_m.size());
  message->row_step = 20 * message->width;
  return message;
}
Points cloud(std::size_t scan) { return cloud(scan, scan); }

geometry_msgs::msg::TransformStamped transform(double x_m, double y_m, double z_m) {
  return transform_of(0, "", "", {{x_m, y_m, z_m}, {0, 0, 0, 1}});
}

class Ros2Localizer : public testing::Test {
 protected:
  void SetUp() override {
    rclcpp::recorded() = {};
    tf2::recorded() = {};
    tf2::recorded().known[{"base_link", "lidar"}] = transform(0.0, 0.0, 2.0);
  }
  template <class NodeT = LocalizerNode>
  static std::unique_ptr<NodeT> node(std::vector<rclcpp::Parameter> further = {}) {
    std::vector<rclcpp::Parameter> parameters = {{"map_file", ros_street().map_file}};
    parameters.insert(parameters.begin(), further.begin(), further.end());
    return std::make_unique<NodeT>(rclcpp::NodeOptions().parameter_overrides(parameters));
  }
  static void send(const std::string& topic, const std::shared_ptr<void>& message) {
    rclcpp::recorded().subscribed.at(topic)(message);
  }
  static void activate() {
    const auto request = std::make_shared<SetBool::Request>();
    const auto response = std::make_shared<SetBool::Response>();
    request->data = true;
    rclcpp::recorded().services.at("trigger_node_srv")(request, response);
    EXPECT_TRUE(response->success);
  }
  static void send_poses(std::size_t scan, double ahead_m) {
    for (const int step : {-1, 0}) {
      StampedPose pose{stamp_ns(scan) + step * 50'000'000, truth(scan), {}};
      pose.pose.position_m[0] += ahead_m + 0.2 * step;
      for (std::size_t i = 0; i < 6; ++i) pose.covariance[7 * i] = i < 3 ? 0.09 : 4e-4;
      send("ekf_pose_with_covariance",
           std::make_shared<PoseWithCovarianceStamped>(message_of(pose, "map")));
    }
  }
  template <class T>
  static T last(const std::string& topic) {
    return *std::static_pointer_cast<T>(rclcpp::recorded().published.at(topic).back());
  }
  static std::size_t count(const std::string& topic) {
    return rclcpp::recorded().published[topic].size();
  }
  static diagnostic_msgs::msg::DiagnosticStatus status(const std::string& name) {
    const auto& all = rclcpp::recorded().published["/diagnostics"];
    for (auto i = all.rbegin(); i != all.rend(); ++i) {
      const auto message = *std::static_pointer_cast<DiagnosticArray>(*i);
      if (message.status.at(0).name == "sightline_localizer: " + name) return message.status[0];
    }
    return {};
  }
};

TEST_F(Ros2Localizer, PublishesThePoseAndAllFiguresOfAScan) {
  const auto localizer = node({{"score_estimation.no_ground_points.enable", true}});
  rclcpp::recorded().subscriber_count = {{"points_aligned", 1}, {"points_aligned_no_ground", 1}};
  activate();
  send_poses(12, -0.2);
  send("points_raw", cloud(12));
  const auto pose = last<PoseStamped>("ndt_pose");
  EXPECT_EQ(pose.header.frame_id, "map");
  EXPECT_EQ(ns_of(pose.header.stamp), stamp_ns(12));
  EXPECT_LT(distance_m(pose_of(pose.pose).position_m, truth(12).position_m), 0.02);
  const auto with_covariance = last<PoseWithCovarianceStamped>("ndt_pose_with_covariance");
  EXPECT_EQ(with_covariance.pose.pose.position.x, pose.pose.position.x);
  EXPECT_GT(with_covariance.pose.covariance[0], 0.0);
  EXPECT_NEAR(last<Float32Stamped>("initial_to_result_distance").data, 0.2F, 0.03F);
  EXPECT_NEAR(last<Float32Stamped>("initial_to_result_distance_old").data, 0.2F, 0.03F);
  EXPECT_GT(last<Float32Stamped>("transform_probability").data, 1.0F);
  EXPECT_GT(last<Float32Stamped>("nearest_voxel_transformation_likelihood").data, 1.0F);
  EXPECT_GT(last<Float32Stamped>("no_ground_transform_probability").data, 1.0F);
  EXPECT_GT(last<Float32Stamped>("no_ground_nearest_voxel_transformation_likelihood").data, 1.0F);
  EXPECT_GT(last<Float32Stamped>("exe_time_ms").data, 0.0F);
  EXPECT_EQ(count("iteration_num"), 1U);
  EXPECT_NEAR(last<PoseStamped>("initial_to_result_relative_pose").pose.position.x, 0.2, 0.03);
  EXPECT_EQ(count("initial_pose_with_covariance"), 1U);
  const auto aligned = last<PointCloud2>("points_aligned");
  EXPECT_EQ(aligned.header.frame_id, "map");
  EXPECT_EQ(aligned.width, cloud(12)->width);
  EXPECT_LT(last<PointCloud2>("points_aligned_no_ground").width, aligned.width);
  ASSERT_EQ(tf2::recorded().sent.size(), 1U);
  EXPECT_EQ(tf2::recorded().sent[0].child_frame_id, "ndt_base_link");
  EXPECT_EQ(status("scan_matching_status").level, 0) << status("scan_matching_status").message;
}

TEST_F(Ros2Localizer, CloudsAreMovedOnlyForSubscribers) {
  const auto localizer = node();
  activate();
  send_poses(5, 0.1);
  send("points_raw", cloud(5));
  EXPECT_EQ(count("ndt_pose"), 1U);
  EXPECT_EQ(count("points_aligned"), 0U);
  EXPECT_EQ(count("no_ground_transform_probability"), 0U);
}

TEST_F(Ros2Localizer, GivesNoPoseBeforeItIsActivatedAndSaysSo) {
  const auto localizer = node();
  send_poses(5, 0.1);
  send("points_raw", cloud(5));
  EXPECT_EQ(count("ndt_pose"), 0U);
  EXPECT_EQ(status("scan_matching_status").level, 1);
  EXPECT_EQ(status("initial_pose_subscriber_status").level, 1);
  rclcpp::recorded().timers.at(0)();
  EXPECT_EQ(status("map_update_status").level, 1);
  activate();
  EXPECT_EQ(status("trigger_node_service_status").level, 0);
}

TEST_F(Ros2Localizer, NamesATransformOrPointsThatItNeeds) {
  const auto localizer = node();
  activate();
  tf2::recorded().known.clear();
  send("points_raw", cloud(5));
  EXPECT_EQ(status("scan_matching_status").level, 2);
  EXPECT_THAT(status("scan_matching_status").message, HasSubstr("from 'lidar' to 'base_link'"));
  for (const auto& spoil : std::vector<std::function<void(PointCloud2&)>>{
           [](PointCloud2& c) { c.fields.erase(c.fields.begin()); },
           [](PointCloud2& c) { c.fields[1].offset = 12; },
           [](PointCloud2& c) { c.data.pop_back(); }, [](PointCloud2& c) { c.is_bigendian = true; },
           [](PointCloud2& c) { c.fields[2].datatype = 8; }}) {
    const Points spoiled = cloud(5);
    spoil(*spoiled);
    EXPECT_FALSE(points_of(*spoiled));
    send("points_raw", spoiled);
  }
  EXPECT_EQ(count("ndt_pose"), 0U);
}

TEST_F(Ros2Localizer, AnswersWhereAScanIs) {
  const auto localizer = node();
  const auto request = std::make_shared<Align::Request>();
  const auto response = std::make_shared<Align::Response>();
  StampedPose start{stamp_ns(8), truth(8), {}};
  start.pose.position_m[0] += 1.0;
  start.pose.quaternion_xyzw = quaternion_of_yaw(1.5);
  start.covariance[0] = start.covariance[7] = 1.0;
  request->pose_with_covariance = message_of(start, "map");
  const auto call = [&] { rclcpp::recorded().services.at("ndt_align_srv")(request, response); };
  call();
  EXPECT_FALSE(response->success) << "no scan yet";
  send("points_raw", cloud(8));
  call();
  EXPECT_TRUE(response->success);
  EXPECT_TRUE(response->reliable) << status("ndt_align_service_status").message;
  const Pose found = pose_of(response->pose_with_covariance.pose.pose);
  EXPECT_LT(distance_m(found.position_m, truth(8).position_m), 0.02);
  EXPECT_FALSE(last<visualization_msgs::msg::MarkerArray>("monte_carlo_initial_pose_marker")
                   .markers.empty());
  request->pose_with_covariance.header.frame_id = "gnss";
  call();
  EXPECT_EQ(status("ndt_align_service_status").level, 2);
}

TEST_F(Ros2Localizer, TakesAutowaresOwnParametersForScoreAndCovariance) {
  std::vector<double> fixed(36, 0.0);
  for (std::size_t i = 0; i < 36; i += 7) fixed[i] = 0.25;
  const auto localizer =
      node({{"score_estimation.converged_param_type", std::int64_t{1}},
            {"score_estimation.converged_param_nearest_voxel_transformation_likelihood", 99.0}});
  activate();
  send_poses(5, 0.1);
  send("points_raw", cloud(5));
  EXPECT_EQ(count("ndt_pose"), 0U);
  EXPECT_THAT(status("scan_matching_status").message, HasSubstr("threshold of 99"));
  const auto second =
      node({{"covariance.covariance_estimation.covariance_estimation_type", std::int64_t{0}},
            {"covariance.output_pose_covariance", fixed}});
  activate();
  send_poses(5, 0.1);
  send("points_raw", cloud(5));
  EXPECT_NEAR(last<PoseWithCovarianceStamped>("ndt_pose_with_covariance").pose.covariance[7], 0.25,
              1e-9);
}

TEST_F(Ros2Localizer, DoesNotBeginWithoutItsMapOrWithBadParameters) {
  EXPECT_THROW(node({{"map_file", std::string("/no/such.slmap")}}), std::runtime_error);
  EXPECT_THROW(node({{"score_estimation.converged_param_type", std::int64_t{7}}}),
               std::runtime_error);
  EXPECT_THROW(node({{"covariance.output_pose_covariance", std::vector<double>{1.0}}}),
               std::runtime_error);
}

class Ros2Nav2 : public Ros2Localizer {
 protected:
  static void drive(std::size_t scan, std::size_t of_scan) {
    tf2::recorded().known[{"odom", "base_link"}] =
        transform(0.41 * static_cast<double>(scan), 0.0, 0.0);
    send("points", cloud(scan, of_scan));
  }
  static void give_initial_pose() {
    StampedPose initial{0, truth(0), {}};
    initial.pose.position_m[1] += 0.5;
    initial.pose.position_m[2] = 0.0;
    initial.covariance[0] = initial.covariance[7] = 0.25;
    send("initialpose", std::make_shared<PoseWithCovarianceStamped>(message_of(initial, "map")));
  }
};

TEST_F(Ros2Nav2, FollowsOdometryFromAnInitialPose) {
  const auto nav2 = node<Nav2Node>();
  using Return = Nav2Node::Return;
  ASSERT_EQ(nav2->on_configure({}), Return::SUCCESS);
  drive(0, 0);
  EXPECT_EQ(count("amcl_pose"), 0U) << "not active";
  ASSERT_EQ(nav2->on_activate({}), Return::SUCCESS);
  drive(0, 0);
  EXPECT_EQ(count("amcl_pose"), 0U) << "no initial pose";
  give_initial_pose();
  for (std::size_t i = 0; i < 20; ++i) drive(i, i);
  EXPECT_EQ(count("amcl_pose"), 20U);
  const auto pose = last<PoseWithCovarianceStamped>("amcl_pose");
  EXPECT_LT(distance_m(pose_of(pose.pose.pose).position_m, truth(19).position_m), 0.03);
  const auto& sent = tf2::recorded().sent.back();
  EXPECT_EQ(sent.header.frame_id, "map");
  EXPECT_EQ(sent.child_frame_id, "odom");
  EXPECT_NEAR(sent.transform.translation.x + 0.41 * 19, truth(19).position_m[0], 0.05);
  EXPECT_EQ(ns_of(sent.header.stamp), stamp_ns(19) + 500'000'000);
  EXPECT_EQ(status("localization").level, 0) << status("localization").message;
  ASSERT_EQ(nav2->on_deactivate({}), Return::SUCCESS);
  drive(20, 20);
  EXPECT_EQ(count("amcl_pose"), 20U);
  ASSERT_EQ(nav2->on_cleanup({}), Return::SUCCESS);
  send("points", cloud(21));
}

TEST_F(Ros2Nav2, StartsFromItsParametersAndSaysWhereOdometryIsMissing) {
  const Pose first = truth(0);
  const auto nav2 = node<Nav2Node>({{"set_initial_pose", true},
                                    {"initial_pose.x", first.position_m[0] + 0.4},
                                    {"initial_pose.y", first.position_m[1]},
                                    {"initial_pose.yaw", 1.0}});
  nav2->on_configure({});
  nav2->on_activate({});
  send("points", cloud(0));
  EXPECT_THAT(status("localization").message, HasSubstr("from 'base_link' to 'odom'"));
  drive(0, 0);
  EXPECT_EQ(count("amcl_pose"), 1U) << status("localization").message;
}

TEST_F(Ros2Nav2, ConfiguresOnlyWithAMap) {
  const auto nav2 = node<Nav2Node>({{"map_file", std::string("/no/such.slmap")}});
  EXPECT_EQ(nav2->on_configure({}), Nav2Node::Return::FAILURE);
}

}  // namespace
}  // namespace sightline_ros2
