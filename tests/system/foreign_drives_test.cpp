#include <gtest/gtest.h>

#include "formats/foreign/pose_file.h"
#include "formats/foreign/recording.h"
#include "formats/foreign/ros_messages.h"
#include "tests/formats/foreign/bag_files.h"
#include "tests/system/program.h"

// The small town's mapping drive told in another way.

namespace sightline {
namespace {

// The town's clock begins at 0, which in a bag means that there is no stamp.
constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kShift_ns = 100 * kSecond_ns;

Recording mapping_recording() {
  RecordingOptions options;
  options.scans = (small_town() / "mapping" / "scans").string();
  options.poses = (small_town() / "mapping" / "poses.tum").string();
  const Result<Recording> recording = open_recording(options, 2);
  EXPECT_TRUE(recording.has_value());
  return recording ? *recording : Recording{};
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
  const ProgramResult run =
      run_sightline("compile " + (folder / "drive.yaml").string() + " -q --no-cache --force -o " +
                    (folder / "drive.slmap").string());
  EXPECT_EQ(run.status, 0) << run.err;
  return (folder / "drive.slmap").string();
}

TEST(ForeignDrives, ABagCompilesToTheSameMapAsTheFolderItCameFrom) {
  const std::filesystem::path folder = fresh_folder();
  const Recording recording = mapping_recording();
  std::vector<BagMessage> messages;
  std::vector<PoseRow> rows;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const Result<PointCloudFile> cloud = read_recorded_scan(recording, i);
    ASSERT_TRUE(cloud.has_value());
    rows.push_back(
        {recording.scans[i].stamp_ns + kShift_ns, {}, *recording.scans[i].T_world_vehicle});
    std::string data;
    for (const Eigen::Vector3d& point_m : cloud->points_m) {
      const Eigen::Vector3f p = point_m.cast<float>();
      data += as_bytes({p.x(), p.y(), p.z()});
    }
    const auto seconds = static_cast<std::uint32_t>(kShift_ns / kSecond_ns +
                                                    recording.scans[i].stamp_ns / kSecond_ns);
    const auto rest_ns = static_cast<std::uint32_t>(recording.scans[i].stamp_ns % kSecond_ns);
    messages.push_back(
        {"/points", std::string(kPointCloud2), seconds, rest_ns,
         cloud_message(seconds, rest_ns, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}},
                       static_cast<std::uint32_t>(cloud->points_m.size()), 12, data)});
  }
  write_bag(folder / "drive.bag", messages, rosbag::compression::LZ4, 1U << 20U);
  const std::string poses = (folder / "poses.tum").string();
  ASSERT_TRUE(write_tum(poses, rows).has_value());
  const std::string from_bag = compile(
      folder, "mapping: {name: town, scans: drive.bag, topic: /points, poses: " + poses + "}\n");
  const Result<std::string> bag_map = read_text_file(from_bag);
  const std::string from_folder = compile(
      folder, "mapping: {name: town, scans: " + (small_town() / "mapping" / "scans").string() +
                  ", poses: " + poses + "}\n");
  const Result<std::string> folder_map = read_text_file(from_folder);
  ASSERT_TRUE(bag_map.has_value() && folder_map.has_value());
  EXPECT_TRUE(*bag_map == *folder_map) << "the maps differ";
}

}  // namespace
}  // namespace sightline
