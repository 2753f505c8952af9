#include "formats/foreign/text/kitti_calibration.h"

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

}  // namespace
}  // namespace sightline
