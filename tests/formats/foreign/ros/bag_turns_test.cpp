#include "formats/foreign/ros/ros_bag.h"

#include <limits>

#include "formats/foreign/recording/open_recording.h"
#include "tests/formats/foreign/ros/ros2_recordings.h"

// Turn rates of inertial units, in recordings by other writers (recordings/README.md) and in bags
// that librosbag writes.

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
constexpr std::int64_t kFirst_ns = 1'000'000'000LL * kFirst_s;
class OtherWriters : public testing::TestWithParam<const char*> {};

TEST_P(OtherWriters, GiveRatesAboutTheAxesOfTheSensor) {
  const BagTurns turns = value_of(read_bag_turns(recording_path(GetParam()), "", "lidar"));
  EXPECT_THAT(
      turns.warnings,
      ElementsAre(HasSubstr("turn rates are taken from /imu/data; the bag has /camera/imu (frame "
                            "'camera_imu', 70 messages), /imu/data"),
                  HasSubstr("/imu/data: 2 of 35 messages are damaged"),
                  HasSubstr("/imu/data: 1 of 35 messages have times before"),
                  HasSubstr("/imu/data: 1 of 35 messages have the time of another message")));
  // Messages -2 to 32 without 5 (not a number), 7 (says nothing) and 10 (said twice).
  ASSERT_EQ(turns.of_sensor.size(), 32U);
  EXPECT_EQ(turns.of_sensor.front().stamp_ns, kFirst_ns - 20'000'000);
  EXPECT_EQ(turns.of_sensor.back().stamp_ns, kFirst_ns + 320'000'000);
  for (std::size_t i = 0; i < turns.of_sensor.size(); ++i) {
    const TurnRate& rate = turns.of_sensor[i];
    if (i > 0) {
      EXPECT_GT(rate.stamp_ns, turns.of_sensor[i - 1].stamp_ns);
    }
    // The fifteenth message carries the stamp of one before the fourteenth.
    const std::int64_t after_ns = rate.stamp_ns - kFirst_ns;
    const double tenths = after_ns == 135'000'000 ? 15.0 : 1e-7 * static_cast<double>(after_ns);
    // The unit lies on its side, its y up; the sensor looks back.
    EXPECT_TRUE(rate.rate_rad_per_s.isApprox(Eigen::Vector3d(-0.1 * tenths, -3.0, 2.0), 1e-12))
        << rate.rate_rad_per_s.transpose();
  }
}

TEST_P(OtherWriters, TravelWithTheDriveAboutTheAxesOfTheVehicle) {
  RecordingOptions options;
  options.scans = recording_path(GetParam());
  options.lidar_yaw_deg = 180.0;
  const Recording recording = value_of(open_recording(options));
  ASSERT_EQ(recording.turn_rates.size(), 32U);
  EXPECT_TRUE(
      recording.turn_rates.front().rate_rad_per_s.isApprox(Eigen::Vector3d(-0.2, 3.0, 2.0), 1e-12));
  EXPECT_EQ(recording.warnings.size(), 4U);
  // The camera's place is unknown, and the recording is another one without rates.
  options.imu_topic = "/camera/imu";
  const Recording without = value_of(open_recording(options));
  EXPECT_TRUE(without.turn_rates.empty());
  EXPECT_THAT(without.warnings,
              ElementsAre(HasSubstr("no static transforms give the pose of /camera/imu (frame "
                                    "'camera_imu', 70 messages) in the scans' frame 'lidar'")));
  EXPECT_NE(without.digest, recording.digest);
  options.imu_topic = "none";
  const Recording unused = value_of(open_recording(options));
  EXPECT_TRUE(unused.turn_rates.empty() && unused.warnings.empty());
  options.imu_topic = "/points";
  EXPECT_EQ(open_recording(options).error().code, ErrorCode::kUnknownName);
}

INSTANTIATE_TEST_SUITE_P(EveryForm, OtherWriters, testing::Values("imus.mcap", "imus.db3"),
                         [](const auto& test) { return std::string(test.param).substr(5); });

std::string imu_message(std::uint32_t nanoseconds, const std::string& frame,
                        const Eigen::Vector3d& rate, double covariance = 0.0) {
  std::string rest;
  rest += as_bytes({rate.x(), rate.y(), rate.z(), covariance});
  return ros_header(kFirst_s, nanoseconds, frame) + std::string(13 * 8, '\0') + rest +
         std::string((8 + 3 + 9) * 8, '\0');
}

class BagTurnsTest : public testing::Test {
 protected:
  void add(const std::string& topic, std::uint32_t i, const std::string& bytes) {
    messages_.push_back({topic, "sensor_msgs/Imu", kFirst_s, 10'000'000 * i, bytes});
  }
  Result<BagTurns> read(const std::string& topic = "") {
    write_bag(folder_ / "drive.bag", messages_, rosbag::compression::Uncompressed);
    return read_bag_turns(folder_ / "drive.bag", topic, "lidar");
  }

  ScratchFolder folder_;
  std::vector<BagMessage> messages_;
};

TEST_F(BagTurnsTest, AreThoseOfTheOnlyUnitInTheFrameOfTheScans) {
  for (std::uint32_t i = 0; i < 5; ++i) {
    add("/imu", i, imu_message(10'000'000 * i, "lidar", {0.1 * i, 0.2, -0.3}));
  }
  const BagTurns turns = value_of(read());
  EXPECT_THAT(turns.warnings, IsEmpty());
  ASSERT_EQ(turns.of_sensor.size(), 5U);
  EXPECT_EQ(turns.of_sensor[3].rate_rad_per_s, Eigen::Vector3d(0.1 * 3, 0.2, -0.3));
  EXPECT_EQ(turns.of_sensor[3].stamp_ns, kFirst_ns + 30'000'000);
}

TEST_F(BagTurnsTest, SkipWhatIsDamagedAndCountIt) {
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  add("/imu", 0, imu_message(0, "lidar", {1, 2, 3}));
  add("/imu", 1, imu_message(10'000'000, "lidar", {nan, 2, 3}));
  add("/imu", 2, imu_message(20'000'000, "lidar", {1, 2, infinity}));
  add("/imu", 3, imu_message(30'000'000, "lidar", {1, 200, 3}));
  add("/imu", 4, imu_message(40'000'000, "lidar", {1, 2, 3}, -1.0));
  const std::string whole = imu_message(50'000'000, "lidar", {1, 2, 3});
  add("/imu", 5, whole.substr(0, whole.size() - 1));
  add("/imu", 6, "");
  const BagTurns turns = value_of(read());
  EXPECT_EQ(turns.of_sensor.size(), 1U);
  EXPECT_THAT(turns.warnings, ElementsAre(HasSubstr("/imu: 6 of 7 messages are damaged")));
}

TEST_F(BagTurnsTest, AreNoneWhereNothingTellsHowTheUnitSits) {
  add("/imu", 0, imu_message(0, "imu_link", {1, 2, 3}));
  const BagTurns turns = value_of(read());
  EXPECT_THAT(turns.of_sensor, IsEmpty());
  EXPECT_THAT(turns.warnings,
              ElementsAre(HasSubstr("turn rates are not used: no static transforms")));
}

TEST_F(BagTurnsTest, AreNoneWithoutAWordWhereThereIsNoUnit) {
  messages_.push_back({"/other", "std_msgs/String", kFirst_s, 0, ros_text("x")});
  const BagTurns turns = value_of(read());
  EXPECT_THAT(turns.of_sensor, IsEmpty());
  EXPECT_THAT(turns.warnings, IsEmpty());
  EXPECT_EQ(read("/imu").error().code, ErrorCode::kUnknownName);
}

TEST_F(BagTurnsTest, AreNoneWithAWarningWhereTransformsAreDamagedAndNoTopicIsNamed) {
  add("/imu", 0, imu_message(0, "imu_link", {1, 2, 3}));
  messages_.push_back({"/tf_static", "tf2_msgs/TFMessage", kFirst_s, 0, "damaged"});
  const BagTurns turns = value_of(read());
  EXPECT_THAT(turns.of_sensor, IsEmpty());
  EXPECT_THAT(turns.warnings, ElementsAre(HasSubstr("a message of transforms is cut short")));
  EXPECT_EQ(read("/imu").error().code, ErrorCode::kMalformedPose);
}

}  // namespace
}  // namespace sightline
