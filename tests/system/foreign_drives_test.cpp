#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "formats/base/units.h"
#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/ros/scan_messages.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/foreign/bag_files.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

// The town's clock begins at 0, which in a bag means that there is no stamp.
constexpr std::int64_t kShift_ns = 100 * kSecond_ns;

Recording mapping_recording() {
  RecordingOptions options;
  options.scans = (small_town() / "mapping" / "scans").string();
  options.poses = (small_town() / "mapping" / "poses.tum").string();
  return value_of(open_recording(options, 2));
}

std::string config(const std::string& mapping) {
  const std::string town = small_town().string();
  return "annotation: {ranges_m: [10, 30]}\n" + mapping + "localization: {scans: " + town +
         "/drive_1/scans, poses: " + town +
         "/drive_1/poses.tum}\n"
         "measure-error: {offset_count: 3, reference: known}\ntrain-model: {trees: 20}\n";
}

std::string compile(const std::filesystem::path& folder, const std::string& mapping) {
  EXPECT_TRUE(write_file_atomically(folder / "drive.yaml", config(mapping), IfExists::kReplace));
  run_successfully("compile " + (folder / "drive.yaml").string() + " -q --no-cache --force -o " +
                   (folder / "drive.slmap").string());
  return (folder / "drive.slmap").string();
}

// How many lines tell of the NDs of a map; what follows them in a compile is not made.
std::size_t nd_count(const std::filesystem::path& folder, const std::string& mapping) {
  EXPECT_TRUE(write_file_atomically(folder / "drive.yaml", config(mapping), IfExists::kReplace));
  const ProgramResult run =
      run_successfully("compile " + (folder / "drive.yaml").string() +
                       " -q --no-cache --stop-after build-ndt --print-after build-ndt");
  return static_cast<std::size_t>(std::ranges::count(run.out, '\n'));
}

CompiledMap without_recordings(const std::string& file) {
  CompiledMap map = value_of(read_map(file));
  ByFamily<ErrorModel> model = value_of(model_of(map.model));
  visit_families(model, [](ErrorModel& of) {
    for (RecordingCard& card : of.card.places.at(0).recordings.cards) card.digest = sha256("any");
  });
  map.model = record_of(model);
  for (RecordingCard& card : map.recordings->cards) card.digest = sha256("any");
  return map;
}

TEST(ForeignDrives, ABagCompilesToTheSameMapAsTheFolderItCameFromButForTheNameOfItsData) {
  const std::filesystem::path folder = fresh_folder();
  const Recording recording = mapping_recording();
  std::vector<BagMessage> messages;
  std::vector<PoseRow> rows;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const PointCloudFile cloud = value_of(read_recorded_scan(recording, i));
    rows.push_back(
        {recording.scans[i].stamp_ns + kShift_ns, {}, *recording.scans[i].T_world_vehicle});
    std::string data;
    for (const Eigen::Vector3d& point_m : cloud.points_m) {
      const Eigen::Vector3f p = point_m.cast<float>();
      data += as_bytes({p.x(), p.y(), p.z()});
    }
    const auto seconds = static_cast<std::uint32_t>(kShift_ns / kSecond_ns +
                                                    recording.scans[i].stamp_ns / kSecond_ns);
    const auto rest_ns = static_cast<std::uint32_t>(recording.scans[i].stamp_ns % kSecond_ns);
    messages.push_back(
        {"/points", std::string(kPointCloud2), seconds, rest_ns,
         cloud_message(seconds, rest_ns, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}},
                       static_cast<std::uint32_t>(cloud.points_m.size()), 12, data)});
  }
  write_bag(folder / "drive.bag", messages, rosbag::compression::LZ4, 1U << 20U);
  const std::string poses = (folder / "poses.tum").string();
  ASSERT_TRUE(write_tum(poses, rows).has_value());
  const std::string from_bag = compile(
      folder, "mapping: {name: town, scans: drive.bag, topic: /points, poses: " + poses + "}\n");
  const CompiledMap bag_map = without_recordings(from_bag);
  const std::string bag_bytes = bytes_of(from_bag);
  const std::string from_folder = compile(
      folder, "mapping: {name: town, scans: " + (small_town() / "mapping" / "scans").string() +
                  ", poses: " + poses + "}\n");
  EXPECT_FALSE(bag_bytes == bytes_of(from_folder)) << "the models name the same files";
  EXPECT_TRUE(encode_map(bag_map) == encode_map(without_recordings(from_folder)))
      << "the maps differ";
}

// Front and rear half of every scan, as a sensor would see them that sits there: the rear one looks
// backwards, 1.5 m behind, and scans at the same time.
TEST(ForeignDrives, TwoSensorsThatSeeHalfEachMakeTheMapOfOneThatSeesAll) {
  const std::filesystem::path folder = fresh_folder();
  const Recording recording = mapping_recording();
  Pose T_front_rear = Pose::Identity();
  T_front_rear.translation().x() = -1.5;
  T_front_rear.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  const Pose T_rear_front = T_front_rear.inverse();
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const PointCloudFile cloud = value_of(read_recorded_scan(recording, i));
    std::vector<PointXyzi> front;
    std::vector<PointXyzi> rear;
    for (const Eigen::Vector3d& point_m : cloud.points_m) {
      const bool is_front = point_m.x() >= -0.75;
      const Eigen::Vector3f p =
          (is_front ? point_m : Eigen::Vector3d(T_rear_front * point_m)).cast<float>();
      (is_front ? front : rear).push_back({p.x(), p.y(), p.z(), 0.0F});
    }
    const std::string& name = recording.scans[i].name;
    ASSERT_TRUE(write_pcd_binary(folder / "front" / name, front).has_value());
    ASSERT_TRUE(write_pcd_binary(folder / "rear" / name, rear).has_value());
  }
  std::string stamps;
  for (const RecordedScan& scan : recording.scans) stamps += format_stamp(scan.stamp_ns) + "\n";
  ASSERT_TRUE(write_file_atomically(folder / "times.txt", stamps, IfExists::kReplace));
  const std::string poses = (small_town() / "mapping" / "poses.tum").string();
  const auto mapping = [&](const std::string& scans) {
    return "mapping: {scans: " + scans + ", poses: " + poses + "}\n";
  };
  const std::size_t whole =
      nd_count(folder, mapping((small_town() / "mapping" / "scans").string()));
  const std::size_t half = nd_count(folder, mapping("front"));
  const std::size_t both =
      nd_count(folder, mapping("front") +
                           "mapping-2: {scans: rear, stamps: times.txt, lidar_x_m: -1.5, "
                           "lidar_yaw_deg: 180}\n");
  EXPECT_GT(whole, 1000U);
  EXPECT_LT(static_cast<double>(half), 0.98 * static_cast<double>(whole));
  EXPECT_NEAR(static_cast<double>(both), static_cast<double>(whole),
              0.01 * static_cast<double>(whole));
}

}  // namespace
}  // namespace sightline
