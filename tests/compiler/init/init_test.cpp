#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <numbers>

#include "compiler/driver/configuration.h"
#include "compiler/init/draft_config.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/pose_file.h"
#include "passes/ingest/guess_sensor.h"
#include "tests/formats/foreign/bag_files.h"
#include "tests/support/box_world.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
constexpr double kHeight_m = 1.7;
constexpr double kRadians = std::numbers::pi / 180.0;

// Houses of different depth on both sides, so that a scan fits in one place alone.
BoxWorld street() {
  BoxWorld world;
  Random random(7);
  for (int i = -8; i < 20; ++i) {
    const double x_m = 6.0 * i;
    for (const double side : {-1.0, 1.0}) {
      const double near_m = random.uniform(5.0, 12.0);
      const double low_m = side > 0.0 ? near_m : -near_m - 3.0;
      world.boxes.push_back(
          {{x_m, low_m, 0.0},
           {x_m + random.uniform(1.0, 5.0), low_m + 3.0, random.uniform(2.0, 9.0)}});
    }
  }
  return world;
}

PointCloudFile scan_with(const std::vector<double>& beams_deg, const Pose& T_world_lidar) {
  static const BoxWorld kStreet = street();
  PointCloudFile scan;
  for (double azimuth_deg = 0.1; azimuth_deg < 360.0; azimuth_deg += 1.5) {
    for (const double beam_deg : beams_deg) {
      const double flat = std::cos(beam_deg * kRadians);
      const Eigen::Vector3d direction(flat * std::cos(azimuth_deg * kRadians),
                                      flat * std::sin(azimuth_deg * kRadians),
                                      std::sin(beam_deg * kRadians));
      const double range_m =
          kStreet.cast(T_world_lidar.translation(), T_world_lidar.linear() * direction);
      if (range_m < 60.0) scan.points_m.emplace_back(range_m * direction);
    }
  }
  return scan;
}

struct Way {
  double begin_x_m = 0.0;
  int scans = 24;
  double turned_deg = 0.0;  // of the sensor in the frame of its poses
};

Pose pose_on(const Way& way, int scan) {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(way.begin_x_m + scan, std::sin(0.3 * scan), kHeight_m);
  T.rotate(Eigen::AngleAxisd(0.1 * std::cos(0.3 * scan), Eigen::Vector3d::UnitZ()));
  return T;
}

Pose lidar_on(const Way& way, int scan) {
  Pose T = pose_on(way, scan);
  T.rotate(Eigen::AngleAxisd(way.turned_deg * kRadians, Eigen::Vector3d::UnitZ()));
  return T;
}

void write_scans(const fs::path& folder, const Way& way, bool has_beams = false) {
  fs::create_directories(folder);
  for (int i = 0; i < way.scans; ++i) {
    const PointCloudFile scan =
        scan_with(sensor_profile("vlp-16")->beam_elevations_deg, lidar_on(way, i));
    std::string bytes;
    for (const Eigen::Vector3d& p_m : scan.points_m) {
      const Eigen::Vector3f p = p_m.cast<float>();
      bytes += as_bytes({p.x(), p.y(), p.z(), 0.5F});
      if (has_beams) bytes += as_bytes({std::round(p.z() / p.head<2>().norm() * 30.0F) + 8.0F});
    }
    std::ofstream(folder / (std::to_string(i) + ".bin"), std::ios::binary) << bytes;
  }
}

void write_poses(const fs::path& file, const Way& way) {
  std::vector<PoseRow> rows;
  for (int i = 0; i < way.scans; ++i) rows.push_back({i * 100'000'000LL, {}, pose_on(way, i)});
  ASSERT_TRUE(write_tum(file, rows).has_value());
}

// `axes` says which of x, y and z of the way each axis of the file is.
void write_kitti(const fs::path& file, const Way& way, const Eigen::Matrix3d& axes) {
  std::ofstream stream(file);
  for (int i = 0; i < way.scans; ++i) {
    const Pose T = pose_on(way, 0).inverse() * pose_on(way, i);
    const Eigen::Matrix3d R = axes * T.linear() * axes.transpose();
    const Eigen::Vector3d t_m = axes * T.translation();
    for (int row = 0; row < 3; ++row) {
      stream << R(row, 0) << ' ' << R(row, 1) << ' ' << R(row, 2) << ' ' << t_m[row]
             << (row < 2 ? ' ' : '\n');
    }
  }
}

class Init : public TestInFolder {
 protected:
  CompileConfig draft(const DraftOptions& options = {}) {
    const Result<ConfigDraft> made = draft_config(folder_, folder_ / "drive.yaml", options);
    if (!made) {
      ADD_FAILURE() << to_string(made.error());
      return {};
    }
    yaml_ = made->yaml;
    std::ofstream(folder_ / "drive.yaml") << yaml_;
    return value_of(load_compile_config(folder_ / "drive.yaml", {}), yaml_);
  }
  std::string path(const std::string& below) const { return (folder_ / below).string(); }

  std::string yaml_;
};

TEST_F(Init, GivesThreeDrivesTheirRolesAndTheirPoses) {
  Way way;
  for (const std::string name : {"2024-01", "mapping", "2024-02"}) {
    ++way.scans;  // no two drives are the same recording
    write_scans(folder_ / name / "scans", way);
    write_poses(folder_ / name / "poses.tum", way);
  }
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.scans, path("mapping/scans"));
  EXPECT_EQ(config.mapping.poses, path("mapping/poses.tum"));
  EXPECT_EQ(config.mapping.poses_of, PosesOf::kSensor);
  EXPECT_EQ(config.mapping.sensor, "vlp-16");
  EXPECT_NEAR(config.mapping.height_m, kHeight_m, 0.05);
  EXPECT_EQ(config.localization.scans, path("2024-01/scans"));
  EXPECT_EQ(config.evaluation.scans, path("2024-02/scans"));
  EXPECT_THAT(yaml_, HasSubstr("scans: mapping/scans")) << "paths beneath the file are relative";
  EXPECT_TRUE(open_recording(config.mapping).has_value());
}

// generic-16, vlp-16 and xt16 have the same beams.
TEST_F(Init, PrefersTheSensorThatIsNamed) {
  write_scans(folder_ / "xt16" / "scans", Way());
  EXPECT_EQ(draft().mapping.sensor, "xt16");
  EXPECT_THAT(yaml_, HasSubstr("the path or the topic names it"));
  EXPECT_EQ(draft({.sensor = "hdl-32e"}).mapping.sensor, "hdl-32e");
  EXPECT_THAT(yaml_, HasSubstr("named by --sensor; the scans look like"));
  EXPECT_EQ(code_of(draft_config(folder_, "", {.sensor = "hdl-33"})), ErrorCode::kUnknownName);
}

TEST_F(Init, DoesNotPreferANameWhoseBeamsDoNotFit) {
  write_scans(folder_ / "hdl-32e" / "scans", Way());
  EXPECT_EQ(draft().mapping.sensor, "vlp-16");
}

TEST_F(Init, NamesTheSchemaForEditorsInItsFirstLine) {
  write_scans(folder_ / "scans", Way());
  draft({.schema = "sightline.schema.json"});
  EXPECT_TRUE(yaml_.starts_with("# yaml-language-server: $schema=sightline.schema.json\n"))
      << yaml_;
  draft();
  EXPECT_EQ(yaml_.find("yaml-language-server"), std::string::npos);
}

TEST_F(Init, SplitsASingleDriveAndLeavesItsPosesToTheCompiler) {
  write_scans(folder_, {});
  const CompileConfig config = draft();
  EXPECT_EQ(config.annotation.split, Split::kEvenOdd);
  EXPECT_TRUE(fs::equivalent(config.mapping.scans, folder_));
  EXPECT_EQ(config.mapping.poses, "");
  EXPECT_TRUE(config.localization.scans.empty());
  EXPECT_THAT(yaml_, HasSubstr("no poses were found"));
}

TEST_F(Init, SaysWhatTheFloatsOfScansWithoutAHeaderAre) {
  write_scans(folder_ / "mapping", {});
  write_scans(folder_ / "other", {}, true);
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.columns, "x y z intensity");
  EXPECT_EQ(config.localization.columns, "x y z intensity _");
  EXPECT_TRUE(open_recording(config.localization)->warnings.empty());
}

TEST_F(Init, PassesOverAFolderWithALinkThatLeadsNowhere) {
  write_scans(folder_ / "mapping", {});
  write_scans(folder_ / "other", {});
  fs::create_symlink("gone.bin", folder_ / "other" / "99.bin");
  EXPECT_EQ(draft().localization.scans, "");
  EXPECT_THAT(yaml_, HasSubstr("Not used: other"));
  EXPECT_THAT(yaml_, HasSubstr("gone.bin"));
}

TEST_F(Init, TakesThePosesOfTheSensorBeforeThoseOfTheCamera) {
  write_scans(folder_ / "velodyne", {});
  Eigen::Matrix3d camera;  // x right, y down, z forward
  camera << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  write_kitti(folder_ / "poses.txt", {}, camera);
  EXPECT_EQ(draft().mapping.poses, "");
  EXPECT_THAT(yaml_, HasSubstr("may be those of a camera"));
  write_kitti(folder_ / "poses_of_lidar.txt", {}, Eigen::Matrix3d::Identity());
  EXPECT_EQ(draft().mapping.poses, path("poses_of_lidar.txt"));
}

TEST_F(Init, SaysHowTheSensorIsTurnedInTheFrameOfThePoses) {
  for (const double turned_deg : {90.0, 180.0, -90.0}) {
    fs::remove_all(folder_ / "scans");
    fs::remove(folder_ / "poses.tum");
    const Way way{0.0, 24, turned_deg};
    write_scans(folder_ / "scans", way);
    write_poses(folder_ / "poses.tum", way);
    const CompileConfig config = draft();
    EXPECT_EQ(config.mapping.poses_of, PosesOf::kVehicle);
    EXPECT_EQ(config.mapping.lidar_yaw_deg, turned_deg);
    EXPECT_TRUE(open_recording(config.mapping).has_value());
  }
}

TEST_F(Init, LeavesOutPosesThatTheScansContradict) {
  write_scans(folder_ / "scans", {});
  std::vector<PoseRow> rows;
  for (int i = 0; i < 24; ++i) {
    PoseRow& row = rows.emplace_back();
    row.stamp_ns = i * 100'000'000LL;
    row.T_world_vehicle.translation() = Eigen::Vector3d(0.0, 3.0 * i, 0.0);
    row.T_world_vehicle.rotate(Eigen::AngleAxisd(1.0 * i, Eigen::Vector3d::UnitZ()));
  }
  ASSERT_TRUE(write_tum(folder_ / "poses.tum", rows).has_value());
  EXPECT_EQ(draft().mapping.poses, "");
  EXPECT_THAT(yaml_, HasSubstr("the returns from upright surfaces overlap other scans"));
}

TEST_F(Init, OffersASecondSensorOfTheVehicleButDoesNotGuessWhereItSits) {
  write_scans(folder_ / "front", {});
  write_scans(folder_ / "rear", {});
  write_poses(folder_ / "poses.tum", {});
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.scans, path("front"));
  EXPECT_TRUE(config.is_split());
  EXPECT_TRUE(config.other_sensors[0].scans.empty());
  EXPECT_THAT(yaml_, HasSubstr("# mapping-2: {scans: rear, lidar_x_m: 0"));
  // As it will be read once the # is gone.
  std::string uncommented = yaml_;
  uncommented.replace(uncommented.find("# mapping-2"), 2, "");
  std::ofstream(folder_ / "drive.yaml") << uncommented;
  const CompileConfig both = value_of(load_compile_config(folder_ / "drive.yaml", {}), yaml_);
  EXPECT_EQ(both.other_sensors[0].scans, path("rear"));
}

TEST_F(Init, DoesNotMeasureADriveElsewhereInThisMap) {
  write_scans(folder_ / "a" / "scans", {});
  write_poses(folder_ / "a" / "poses.tum", {});
  write_scans(folder_ / "b" / "scans", {60.0});
  write_poses(folder_ / "b" / "poses.tum", {60.0});
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.scans, path("a/scans"));
  EXPECT_TRUE(config.localization.scans.empty());
  EXPECT_THAT(yaml_, HasSubstr("does not overlap the mapping drive"));
}

std::string cloud_of(const Way& way, int scan, std::uint32_t seconds) {
  const PointCloudFile cloud =
      scan_with(sensor_profile("vlp-16")->beam_elevations_deg, lidar_on(way, scan));
  std::string data;
  for (const Eigen::Vector3d& p_m : cloud.points_m) {
    const Eigen::Vector3f p = p_m.cast<float>();
    data += as_bytes({p.x(), p.y(), p.z()});
  }
  return cloud_message(seconds, 0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}},
                       static_cast<std::uint32_t>(cloud.points_m.size()), 12, data);
}

std::string numbers_of(const Pose& T) {
  const Eigen::Quaterniond q(T.linear());
  return as_bytes(
      {T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w()});
}

BagMessage transform_message(const char* topic, std::uint32_t seconds, const char* parent,
                             const char* child, const Pose& T_parent_child) {
  return {topic, "tf2_msgs/TFMessage", seconds, 0,
          as_bytes({1U, 0U, seconds, 0U}) + ros_text(parent) + ros_text(child) +
              numbers_of(T_parent_child)};
}

// Scans and the vehicle's poses, the sensor's mounting, and where asked for the poses as
// transforms.
std::vector<BagMessage> bag_of(const Way& way, bool has_moving_transforms) {
  std::vector<BagMessage> messages;
  Pose T_vehicle_lidar = Pose::Identity();
  T_vehicle_lidar.rotate(Eigen::AngleAxisd(way.turned_deg * kRadians, Eigen::Vector3d::UnitZ()));
  messages.push_back(transform_message("/tf_static", 100, "base_link", "/lidar", T_vehicle_lidar));
  for (int i = 0; i < way.scans; ++i) {
    const std::uint32_t seconds = 100U + static_cast<std::uint32_t>(i);
    messages.push_back(
        {"/points", "sensor_msgs/PointCloud2", seconds, 0, cloud_of(way, i, seconds)});
    messages.push_back({"/odometry", "geometry_msgs/PoseStamped", seconds, 0,
                        ros_header(seconds, 0) + numbers_of(pose_on(way, i))});
    if (has_moving_transforms) {
      messages.push_back(transform_message("/tf", seconds, "map", "base_link", pose_on(way, i)));
    }
  }
  return messages;
}

TEST_F(Init, ReadsWhatABagHolds) {
  std::vector<BagMessage> messages;
  const Way way;
  for (int i = 0; i < way.scans; ++i) {
    const std::uint32_t seconds = 100U + static_cast<std::uint32_t>(i);
    const std::string cloud = cloud_of(way, i, seconds);
    messages.push_back({"/points", "sensor_msgs/PointCloud2", seconds, 0, cloud});
    if (i % 2 == 0)
      messages.push_back({"/rear/points", "sensor_msgs/PointCloud2", seconds, 0, cloud});
    messages.push_back({"/pose", "geometry_msgs/PoseStamped", seconds, 0,
                        ros_header(seconds, 0) + numbers_of(pose_on(way, i))});
  }
  write_bag(folder_ / "drive.bag", messages);
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.scans, path("drive.bag"));
  EXPECT_EQ(config.mapping.topic, "/points");
  EXPECT_EQ(config.mapping.poses, path("drive.bag"));
  EXPECT_EQ(config.mapping.poses_topic, "/pose");
  EXPECT_EQ(config.mapping.sensor, "vlp-16");
  EXPECT_THAT(yaml_, HasSubstr("# mapping-2: {scans: drive.bag, topic: /rear/points"));
}

TEST_F(Init, NamesTheInertialUnitWhosePlaceIsKnown) {
  std::vector<BagMessage> messages = bag_of({.turned_deg = 30.0}, false);
  const std::uint32_t seconds = messages.front().seconds;
  const std::string numbers(37 * sizeof(double), '\0');
  for (const char* frame : {"lidar", "somewhere"}) {
    messages.push_back({std::string("/imu/") + frame, "sensor_msgs/Imu", seconds, 0,
                        ros_header(seconds, 0, frame) + numbers});
  }
  write_bag(folder_ / "drive.bag", messages);
  EXPECT_EQ(draft().mapping.imu_topic, "/imu/lidar");
  EXPECT_THAT(yaml_, HasSubstr("/imu/somewhere (sensor_msgs/Imu, 1)"));
}

TEST_F(Init, NamesTheTopicOfTheVehiclesSpeed) {
  std::vector<BagMessage> messages = bag_of({.turned_deg = 30.0}, false);
  const std::uint32_t seconds = messages.front().seconds;
  messages.push_back({"/wheels", "geometry_msgs/TwistStamped", seconds, 0,
                      ros_header(seconds, 0, "base_link") + as_bytes({3.0}) +
                          std::string(5 * sizeof(double), '\0')});
  write_bag(folder_ / "drive.bag", messages);
  EXPECT_EQ(draft().mapping.wheel_speed, "/wheels");
}

TEST_F(Init, TakesTheMountingOfTheSensorFromABag) {
  write_bag(folder_ / "drive.bag", bag_of({.turned_deg = 30.0}, false));
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.poses_topic, "/odometry");
  EXPECT_EQ(config.mapping.poses_of, PosesOf::kVehicle);
  EXPECT_EQ(config.mapping.lidar_yaw_deg, 30.0);
  EXPECT_EQ(config.mapping.lidar_pitch_deg, 0.0);
  EXPECT_THAT(yaml_, HasSubstr("/points (sensor_msgs/PointCloud2, 24)"));
}

TEST_F(Init, TakesThePosesOfTheSensorFromTransforms) {
  write_bag(folder_ / "drive.bag", bag_of({.turned_deg = 30.0}, true));
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.poses_topic, "/tf");
  EXPECT_EQ(config.mapping.poses_of, PosesOf::kSensor);
  const Recording recording = value_of(list_recording(config.mapping));
  EXPECT_TRUE(
      recording.scans[5].T_world_vehicle->isApprox(lidar_on({.turned_deg = 30.0}, 5), 1e-9));
}

TEST_F(Init, NamesTheMetadataOfAnOustersCapture) {
  const fs::path captures = SIGHTLINE_CAPTURES;
  fs::copy_file(captures / "ouster_single.pcap", folder_ / "drive.pcap");
  fs::copy_file(captures / "ouster_single.json", folder_ / "roof.json");
  const CompileConfig config = draft();
  EXPECT_EQ(config.mapping.scans, path("drive.pcap"));
  EXPECT_EQ(config.mapping.sensor, path("roof.json"));
  EXPECT_THAT(yaml_, HasSubstr("metadata of the sensor that sent these packets"));
  const SensorProfile sensor = value_of(sensor_of(config.mapping));
  EXPECT_EQ(sensor.name, "OS-1-16");
  EXPECT_EQ(sensor.ring_count(), 16);
}

TEST_F(Init, WritesNamesThatYamlReadsBack) {
  fs::path scans = folder_ / "scans";
  write_scans(scans, {0.0, 21});
  for (const char* name : {"two words", "it's \"quoted\"", "a#b", "key: value", "-dash", "[list]",
                           "stra\u00DFe", "back\\slash", "true", "*star"}) {
    fs::rename(scans, folder_ / name);
    scans = folder_ / name;
    EXPECT_EQ(draft().mapping.scans, path(name));
  }
}

TEST_F(Init, RefusesAFolderWithoutADriveAndSaysWhatItPassedOver) {
  EXPECT_EQ(code_of(draft_config(folder_ / "nowhere", "")), ErrorCode::kFileNotFound);
  EXPECT_EQ(code_of(draft_config(folder_, "")), ErrorCode::kEmptyDirectory);
  for (const char* name : {"1.pcd", "2.pcd"}) {
    std::ofstream(folder_ / name) << "version https://git-lfs.github.com/spec/v1\n";
  }
  EXPECT_THAT(failure_of(draft_config(folder_, "")).message, HasSubstr("git lfs pull"));
}

std::vector<PointCloudFile> scans_with(const std::vector<double>& beams_deg,
                                       double view_deg = 360.0) {
  std::vector<PointCloudFile> scans;
  for (const int place : {3, 9}) {
    PointCloudFile& scan = scans.emplace_back(scan_with(beams_deg, lidar_on({}, place)));
    std::erase_if(scan.points_m, [&](const Eigen::Vector3d& point_m) {
      return std::abs(std::atan2(point_m.y(), point_m.x())) > 0.5 * view_deg * kRadians;
    });
  }
  return scans;
}

TEST(GuessSensor, TellsEveryBuiltInProfileByItsBeams) {
  for (const std::string& name : sensor_profile_names()) {
    const std::vector<double> beams_deg = sensor_profile(name)->beam_elevations_deg;
    // Beams that see only sky here, or ground that is too near to count, cannot be counted
    // apart.
    if (beams_deg.back() > 35.0 || beams_deg.front() < -50.0) continue;
    const SensorGuess guess = guess_sensor(scans_with(beams_deg));
    ASSERT_FALSE(guess.profile.empty()) << name << ": " << guess.reason;
    EXPECT_EQ(sensor_profile(guess.profile)->beam_elevations_deg, beams_deg) << name;
    ASSERT_TRUE(guess.height_m.has_value()) << name;
    EXPECT_NEAR(*guess.height_m, kHeight_m, 0.05) << name;
  }
}

TEST(GuessSensor, CountsTheBeamsOfASensorThatIsNotBuiltIn) {
  std::vector<double> beams_deg;
  for (int i = 0; i < 40; ++i) beams_deg.push_back(-25.0 + i);
  const SensorGuess guess = guess_sensor(scans_with(beams_deg));
  EXPECT_EQ(guess.profile, "");
  EXPECT_EQ(guess.rings, 40);
  EXPECT_NEAR(guess.lowest_beam_deg, -25.0, 0.01);
  EXPECT_NEAR(guess.highest_beam_deg, 14.0, 0.01);
}

TEST(GuessSensor, CountsBeamsThatMergeByTheirReturns) {
  std::vector<double> beams_deg;
  for (int i = 0; i < 12; ++i) beams_deg.push_back(-25.0 + i);
  for (int i = 0; i < 60; ++i) beams_deg.push_back(-13.0 + 0.08 * i);
  const SensorGuess guess = guess_sensor(scans_with(beams_deg));
  EXPECT_EQ(guess.profile, "");
  EXPECT_NEAR(guess.rings, 72, 2);
  EXPECT_THAT(guess.reason, HasSubstr("12 distinct beams are found"));
}

TEST(GuessSensor, AsksForTheNameWhereNothingTells) {
  const SensorGuess guess = guess_sensor({});
  EXPECT_TRUE(sensor_profile(guess.profile).has_value());
  EXPECT_THAT(guess.reason, HasSubstr("name the sensor"));
  EXPECT_FALSE(guess.height_m.has_value());
}

std::vector<PointCloudFile> cropped_scans(const std::string& name, double view_deg) {
  return scans_with(sensor_profile(name)->beam_elevations_deg, view_deg);
}

TEST(GuessSensor, KnowsALivoxAviaByWhatItSees) {
  const SensorGuess guess = guess_sensor(cropped_scans("livox-avia", 70.4));
  EXPECT_EQ(guess.profile, "livox-avia") << guess.reason;
  EXPECT_FALSE(guess.azimuth_view_deg.has_value());
  EXPECT_NE(guess_sensor(cropped_scans("livox-avia", 120.0)).profile, "livox-avia");
  EXPECT_NE(guess_sensor(cropped_scans("livox-avia", 360.0)).profile, "livox-avia");
}

TEST(GuessSensor, SaysHowMuchOfATurnReturnsFill) {
  const SensorGuess guess = guess_sensor(cropped_scans("hdl-64e", 90.0));
  EXPECT_EQ(guess.profile, "hdl-64e");
  ASSERT_TRUE(guess.azimuth_view_deg.has_value());
  EXPECT_NEAR(*guess.azimuth_view_deg, 90.0, 3.0);
  EXPECT_FALSE(guess_sensor(cropped_scans("hdl-64e", 360.0)).azimuth_view_deg.has_value());
}

}  // namespace
}  // namespace sightline
