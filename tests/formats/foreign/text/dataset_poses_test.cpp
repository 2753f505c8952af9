#include "formats/foreign/text/dataset_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

// x forward, y left, z up of the scanner is z, -x, -y of a camera.
constexpr const char* kTr = "Tr: 0 -1 0 0.1 0 0 -1 -0.2 1 0 0 -0.3\n";

Result<KittiCalibration> read(const std::string& name, const std::string& text) {
  const std::filesystem::path file = scratch_folder() / name;
  EXPECT_TRUE(write_file_atomically(file, text, IfExists::kReplace));
  return read_kitti_calibration(file);
}

TEST(KittiCalibration, TakesTheCamerasPosesToTheScanner) {
  const KittiCalibration calibration =
      value_of(read("calib.txt", std::string("P0: 1 0 0 0 0 1 0 0 0 0 1 0\n") + kTr));
  EXPECT_TRUE(lidar_pose(calibration, Pose::Identity()).isApprox(Pose::Identity(), 1e-12));
  Pose ahead = Pose::Identity();
  ahead.translation().z() = 5.0;  // the camera drives along its z
  const Pose found = lidar_pose(calibration, ahead);
  EXPECT_LT((found.translation() - Eigen::Vector3d(5.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_TRUE(found.linear().isApprox(Eigen::Matrix3d::Identity(), 1e-12));
}

TEST(KittiCalibration, TakesTheInertialUnitsPosesToTheScanner) {
  const KittiCalibration calibration =
      value_of(read("calib_imu_to_velo.txt",
                    "calib_time: 25-May-2012\nR: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n"));
  const Pose found = lidar_pose(calibration, Pose::Identity());
  EXPECT_LT((found.translation() - Eigen::Vector3d(0.8, -0.3, 0.8)).norm(), 1e-12)
      << "the scanner, seen from the unit";
}

TEST(KittiCalibration, RefusesWhatIsNone) {
  const auto error_of = [](const std::string& text) {
    return to_string(read("calib.txt", text).error());
  };
  EXPECT_THAT(error_of("P0: 1 2 3\n"), HasSubstr("SL2008"));
  EXPECT_THAT(error_of("Tr: 1 0 0 0 0 1 0 0 0 0 2 0\n"), HasSubstr("SL2011"));
  EXPECT_THAT(error_of("Tr: 1 x\n"), HasSubstr("SL2020"));
  EXPECT_THAT(error_of("R: 1 0 0 0 1 0 0 0 1\n"), HasSubstr("SL2008"));
}

// As the table of v1.0-mini looks.
constexpr const char* kTable = R"([
{"token": "b", "timestamp": 1532402927647951, "rotation": [0.7071067811865476, 0, 0, 0.7071067811865476],
 "translation": [411.3, 1180.9, 0.0]},
{"token": "a", "timestamp": 1532402927612460, "rotation": [1, 0, 0, 0], "translation": [410, 1180, 0]},
{"token": "c", "timestamp": 1532402927612460, "rotation": [1, 0, 0, 0], "translation": [410, 1180, 0]}])";

TEST(NuscenesPoses, AreReadByTimeWithWFirst) {
  const std::vector<PoseRow> rows = value_of(parse_nuscenes_poses(kTable, "ego_pose.json"));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].stamp_ns, 1'532'402'927'612'460'000);
  EXPECT_EQ(rows[1].T_world_vehicle.translation(), Eigen::Vector3d(411.3, 1180.9, 0.0));
  const Eigen::Vector3d forward = rows[1].T_world_vehicle.linear().col(0);
  EXPECT_LT((forward - Eigen::Vector3d::UnitY()).norm(), 1e-12) << "a quarter turn to the left";
}

TEST(NuscenesPoses, RefuseWhatIsNoTableOfThem) {
  const auto error_of = [](const std::string& text) {
    return outcome_of(parse_nuscenes_poses(text, "ego_pose.json"));
  };
  for (const char* text : {"", "{}", "[]", "[1, 2]", "[{\"timestamp\": 1", "nothing"}) {
    EXPECT_THAT(error_of(text), HasSubstr("SL2020")) << text;
  }
  EXPECT_THAT(error_of(R"([{"timestamp": 1, "rotation": [1, 0, 0], "translation": [1, 2, 3]}])"),
              HasSubstr("SL2009"));
  EXPECT_THAT(error_of(R"([{"timestamp": 1, "rotation": [2, 0, 0, 0], "translation": [1, 2, 3]}])"),
              HasSubstr("SL2011"));
  EXPECT_THAT(error_of(std::string(100'000, '[')), HasSubstr("SL2020"));
  const std::string whole = kTable;
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    EXPECT_NE(error_of(whole.substr(0, cut)), "no error") << cut;
  }
}

}  // namespace
}  // namespace sightline
