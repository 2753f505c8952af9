#include <limits>
#include <span>

#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/ros/ros_bag.h"
#include "tests/formats/foreign/ros/ros2_recordings.h"

// Speeds of the vehicle and accelerations, in messages of ROS 2 and in bags that librosbag writes.

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
constexpr std::int64_t kBegin_ns = 1'000'000'000LL * kFirst_s;

std::string numbers(std::size_t count) { return std::string(count * 8, '\0'); }
std::string twist(double x_m_s) { return as_bytes({x_m_s}) + numbers(5); }
std::string odometry_body(double x_m_s) {
  return as_bytes({1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0}) + numbers(36) + twist(x_m_s) + numbers(36);
}

// What follows the header in a message of each type; of Odometry behind its child frame too.
std::string body_of(const std::string& type, double x_m_s) {
  if (type == "nav_msgs/Odometry") return odometry_body(x_m_s);
  if (type.ends_with("VelocityReport")) return as_bytes({static_cast<float>(x_m_s), 0.1F, 0.2F});
  return twist(x_m_s) + (type.ends_with("TwistStamped") ? "" : numbers(36));
}

std::string ros1_message(const std::string& type, std::uint32_t nanoseconds, double x_m_s) {
  return ros_header(kFirst_s, nanoseconds, "base_link") +
         (type == "nav_msgs/Odometry" ? ros_text("base_link") : "") + body_of(type, x_m_s);
}

// Frames of four bytes, so that numbers of eight are aligned behind them.
std::string cdr_message(const std::string& type, double x_m_s) {
  const std::string frame = as_bytes({std::uint32_t{4}}) + std::string("car\0", 4);
  std::string bytes = as_bytes({std::int32_t{7}}) + as_bytes({std::uint32_t{500}}) + frame;
  if (type == "nav_msgs/Odometry") bytes += frame;
  return std::string("\0\1\0\0", 4) + bytes + body_of(type, x_m_s);
}

class EverySpeedMessage : public testing::TestWithParam<const char*> {};

TEST_P(EverySpeedMessage, IsReadInBothEncodingsWithItsSign) {
  const std::string type = GetParam();
  ASSERT_TRUE(is_speed_message(type));
  const auto parse = [&](const std::string& bytes, MessageEncoding encoding) {
    return parse_speed_message(std::as_bytes(std::span(bytes)), type, encoding);
  };
  const std::string ros1 = ros1_message(type, 500, -2.5);
  const std::string ros2 = cdr_message(type, -2.5);
  for (const auto& [bytes, encoding] :
       {std::pair(ros1, MessageEncoding::kRos1), std::pair(ros2, MessageEncoding::kCdr)}) {
    const std::optional<SpeedMessage> speed = parse(bytes, encoding);
    ASSERT_TRUE(speed.has_value());
    EXPECT_EQ(speed->speed_m_s, -2.5);
    EXPECT_EQ(speed->header.stamp_ns % 1000, 500);
    EXPECT_FALSE(parse(bytes.substr(0, bytes.size() - 1), encoding).has_value()) << "cut short";
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(parse(ros1_message(type, 0, nan), MessageEncoding::kRos1).has_value());
  EXPECT_FALSE(parse(ros1_message(type, 0, 151.0), MessageEncoding::kRos1).has_value());
}

INSTANTIATE_TEST_SUITE_P(Types, EverySpeedMessage,
                         testing::Values("geometry_msgs/TwistStamped",
                                         "geometry_msgs/TwistWithCovarianceStamped",
                                         "autoware_vehicle_msgs/VelocityReport",
                                         "autoware_auto_vehicle_msgs/VelocityReport",
                                         "nav_msgs/Odometry"));

class BagSpeedsTest : public testing::Test {
 protected:
  void add(const std::string& topic, const std::string& type, std::uint32_t i, double x_m_s) {
    const std::uint32_t now_ns = 10'000'000 * i;
    messages_.push_back({topic, type, kFirst_s, now_ns, ros1_message(type, now_ns, x_m_s)});
  }
  void add_speeds(const std::string& topic, const std::string& type, double x_m_s = 1.0) {
    for (std::uint32_t i = 0; i < 40; ++i) add(topic, type, i, x_m_s);
  }
  Result<BagSpeeds> read(const std::string& topic = "") {
    write_bag(folder_ / "drive.bag", messages_);
    return read_bag_speeds(folder_ / "drive.bag", topic);
  }

  ScratchFolder folder_;
  std::vector<BagMessage> messages_;
};

constexpr const char* kTwist = "geometry_msgs/TwistStamped";
constexpr const char* kOdometry = "nav_msgs/Odometry";

TEST_F(BagSpeedsTest, AreThoseOfTheOnlyTopicThatHasAny) {
  add_speeds("/odom", kOdometry, 0.0);
  EXPECT_EQ(value_of(read()).topic, "") << "its twist is empty";
  EXPECT_EQ(value_of(read("/odom")).speeds.size(), 40U);
  add_speeds("/slam", kOdometry, 2.0);
  EXPECT_EQ(value_of(read()).topic, "/slam");
  add_speeds("/wheels", kTwist, -1.0);
  const BagSpeeds wheels = value_of(read());
  EXPECT_EQ(wheels.topic, "/wheels") << "before a topic of odometry";
  EXPECT_EQ(wheels.type, kTwist);
  ASSERT_EQ(wheels.speeds.size(), 40U);
  EXPECT_EQ(wheels.speeds[3].stamp_ns, kBegin_ns + 30'000'000);
  EXPECT_EQ(wheels.speeds[3].speed_m_s, -1.0);
  EXPECT_THAT(wheels.warnings, IsEmpty());
  add_speeds("/other", kTwist);
  const BagSpeeds none = value_of(read());
  EXPECT_EQ(none.topic, "");
  EXPECT_THAT(none.speeds, IsEmpty());
  EXPECT_THAT(none.remark, HasSubstr("several topics have speeds of the vehicle: /other"));
}

TEST_F(BagSpeedsTest, LeaveOutFewBadMessagesAndRefuseMany) {
  add_speeds("/wheels", kTwist);
  add("/wheels", kTwist, 40, std::nan(""));
  add("/wheels", kTwist, 41, 1.0);
  messages_.back().bytes = ros1_message(kTwist, 5'000'000, 7.0);
  const BagSpeeds speeds = value_of(read("/wheels"));
  EXPECT_THAT(speeds.warnings,
              ElementsAre(HasSubstr("/wheels: 1 of 42 messages are damaged"),
                          HasSubstr("/wheels: 1 of 42 messages have times before")));
  ASSERT_EQ(speeds.speeds.size(), 41U);
  EXPECT_EQ(speeds.speeds[1].speed_m_s, 7.0);
  for (std::uint32_t i = 42; i < 45; ++i) add("/wheels", kTwist, i, std::nan(""));
  const Error error = read("/wheels").error();
  EXPECT_EQ(error.code, ErrorCode::kBadValue);
  EXPECT_EQ(error.place, "/wheels message 40");
  const BagSpeeds none = value_of(read());
  EXPECT_THAT(none.speeds, IsEmpty());
  EXPECT_THAT(none.warnings, ElementsAre(HasSubstr("wheel speeds are not used: SL1003")));
}

TEST_F(BagSpeedsTest, RefuseTimesOutOfOrderAndTopicsThatAreNone) {
  add_speeds("/wheels", kTwist);
  for (std::size_t i = 30; i < 35; ++i) {
    messages_[i].bytes = ros1_message(kTwist, static_cast<std::uint32_t>(35 - i), 1.0);
  }
  const Error error = read("/wheels").error();
  EXPECT_EQ(error.code, ErrorCode::kTimeRunsBackwards);
  EXPECT_EQ(error.place, "/wheels message 30");
  EXPECT_EQ(read("/other").error().code, ErrorCode::kUnknownName);
}

// Specific forces are read with the turn rates: in the vehicle's axes, where a message has them.
std::string imu_with_force(std::uint32_t nanoseconds, const Eigen::Vector3d& force,
                           double covariance) {
  return ros_header(kFirst_s, nanoseconds, "lidar") + numbers(13) + as_bytes({0.1, 0.2, 0.3}) +
         numbers(9) + as_bytes({force.x(), force.y(), force.z(), covariance}) + numbers(8);
}

class RecordedMotion : public BagSpeedsTest {
 protected:
  void SetUp() override {
    for (std::uint32_t i = 0; i < 20; ++i) {
      const std::uint32_t now_ns = 10'000'000 * i;
      const double covariance = i == 3 ? -1.0 : 0.0;
      const Eigen::Vector3d force = i == 4   ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                    : i == 5 ? Eigen::Vector3d(0.0, std::nan(""), 0.0)
                                             : Eigen::Vector3d(1.0, 2.0, 9.0);
      messages_.push_back(
          {"/imu", "sensor_msgs/Imu", kFirst_s, now_ns, imu_with_force(now_ns, force, covariance)});
    }
    for (std::uint32_t i = 0; i < 3; ++i) {
      messages_.push_back(
          {"/points", "sensor_msgs/PointCloud2", kFirst_s, 50'000'000 * i,
           cloud_message(kFirst_s, 50'000'000 * i, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}}, 1, 12,
                         as_bytes({1.0F, 2.0F, 3.0F}))});
    }
  }
  Result<Recording> open(const std::string& wheel_speed = "") {
    write_bag(folder_ / "drive.bag", messages_);
    RecordingOptions options;
    options.scans = (folder_ / "drive.bag").string();
    options.lidar_yaw_deg = 90.0;
    options.wheel_speed = wheel_speed;
    return open_recording(options);
  }
};

TEST_F(RecordedMotion, HasForcesAboutTheAxesOfTheVehicle) {
  const Recording recording = value_of(open());
  EXPECT_EQ(recording.turn_rates.size(), 20U);
  ASSERT_EQ(recording.specific_forces.size(), 17U);
  EXPECT_TRUE(recording.specific_forces[0].force_m_s2.isApprox(Eigen::Vector3d(-2.0, 1.0, 9.0)));
  EXPECT_THAT(recording.remarks, IsEmpty());
}

TEST_F(RecordedMotion, HasWheelSpeedsWithARemarkAndIsAnotherRecordingWithThem) {
  const Recording without = value_of(open());
  add_speeds("/wheels", kTwist, 3.0);
  const Recording recording = value_of(open());
  EXPECT_EQ(recording.wheel_speeds.size(), 40U);
  EXPECT_THAT(recording.remarks,
              ElementsAre("wheel speeds are those of /wheels (geometry_msgs/TwistStamped, 40 "
                          "messages)"));
  EXPECT_NE(recording.digest, without.digest);
  const Recording unused = value_of(open("none"));
  EXPECT_THAT(unused.wheel_speeds, IsEmpty());
  EXPECT_EQ(unused.digest, without.digest);
  EXPECT_EQ(open("/imu").error().code, ErrorCode::kUnknownName);
}

TEST_F(RecordedMotion, HasNoSpeedsOfAnotherTimeAndSaysSo) {
  for (std::uint32_t i = 0; i < 5; ++i) {
    messages_.push_back({"/wheels", kTwist, kFirst_s, i,
                         ros_header(kFirst_s + 100, 1000 * i, "base_link") + twist(1.0)});
  }
  const Recording recording = value_of(open());
  EXPECT_THAT(recording.wheel_speeds, IsEmpty());
  ASSERT_FALSE(recording.warnings.empty());
  EXPECT_THAT(recording.warnings.back(),
              HasSubstr("wheel speeds are not used: none of the 5 is within the time of a scan"));
}

TEST_F(RecordedMotion, OfAFolderHasNoTopic) {
  RecordingOptions options;
  options.scans = folder_.path().string();
  options.wheel_speed = "/wheels";
  folder_.write("0.bin", as_bytes({1.0F, 2.0F, 3.0F, 0.0F}));
  folder_.write("1.bin", as_bytes({1.0F, 2.0F, 3.0F, 0.0F}));
  const Result<Recording> recording = open_recording(options);
  ASSERT_FALSE(recording.has_value());
  EXPECT_EQ(recording.error().code, ErrorCode::kBadValue);
}

}  // namespace
}  // namespace sightline
