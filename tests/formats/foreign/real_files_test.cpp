#include <cstdlib>

#include "formats/foreign/recording.h"
#include "tests/formats/foreign/foreign_files.h"

// Files that other people's programs wrote. They are not part of the project: SIGHTLINE_DATA names
// the folder where they are unpacked.

namespace sightline {
namespace {

class RealFiles : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("SIGHTLINE_DATA");
    if (folder == nullptr) GTEST_SKIP() << "SIGHTLINE_DATA names no folder of recordings";
    data_ = folder;
  }
  std::filesystem::path data_;
};

struct Read {
  const char* file;
  std::size_t point_count;
  std::uint64_t nonfinite_count;
  std::uint64_t zero_count;
  Eigen::Vector3d lowest_m;
  Eigen::Vector3d highest_m;
};

TEST_F(RealFiles, AreReadWithTheirCountsAndExtents) {
  const std::vector<Read> files = {
      // PCD ascii, versions .5 and 0.7, with normals; binary; compressed with colours and NaN.
      {"pcl_test/bun0.pcd", 397, 0, 0, {-0.094, 0.037, -0.055}, {0.060, 0.184, 0.058}},
      {"pcl_test/bun4.pcd", 361, 0, 0, {-0.062, 0.037, -0.043}, {0.082, 0.185, 0.093}},
      {"pcl_test/octants.pcd", 8, 0, 0, {-9, -9, -9}, {9, -3, -3}},
      {"pcl_test/rops_cloud.pcd", 32087, 0, 0, {-0.420, -0.240, -1.402}, {0.406, 0.249, -1.010}},
      {"pcl_test/curve2d.pcd", 50, 0, 1, {0.020, -0.199, 0.000}, {1.000, 0.200, 0.000}},
      {"pcl_test/curve_close.pcd", 110, 0, 0, {0, 0, 0}, {1, 1, 0}},
      {"pcl_test/colored_cloud.pcd", 1000, 0, 0, {-0.887, -0.651, 0.882}, {0.489, -0.375, 1.532}},
      {"pcl_test/car6.pcd", 10031, 0, 0, {-40.169, -68.560, -6.990}, {-33.950, -61.880, -5.430}},
      {"pcl_test/cturtle.pcd", 167198, 0, 0, {-1.420, -1.050, 1.396}, {1.420, 1.065, 2.000}},
      {"pcl_test/five_people.pcd",
       239075,
       68125,
       0,
       {-1.931, -3.875, 1.759},
       {2.989, 1.141, 9.757}},
      {"pcl_test/office1.pcd", 254456, 52744, 0, {-2.645, -2.196, 1.833}, {1.504, 1.581, 5.364}},
      // PLY: with faces, ascii, a type outside the standard, extra lines in the header.
      {"pcl_test/cube.ply", 24, 0, 0, {-1, -1, -1}, {1, 1, 1}},
      {"pyntcloud/diamond.ply", 6, 0, 0, {0, 0, 0}, {1, 1, 1}},
      {"pyntcloud/diamond_ascii.ply", 6, 0, 0, {0, 0, 0}, {1, 1, 1}},
      {"pyntcloud/diamond_with_bool.ply", 6, 0, 0, {0, 0, 0}, {1, 1, 1}},
      {"small_gicp/source.ply", 64685, 0, 5107, {-23.759, -52.001, -3.021}, {18.480, 6.508, 9.173}},
      // KITTI .bin.
      {"mmdet3d/000008.bin", 17238, 0, 0, {2.889, -26.420, -3.607}, {76.835, 10.278, 2.866}},
  };
  for (const Read& expected : files) {
    const Result<PointCloudFile> cloud = read_point_cloud(data_ / "interop" / expected.file);
    ASSERT_TRUE(cloud.has_value()) << to_string(cloud.error());
    EXPECT_EQ(cloud->points_m.size(), expected.point_count) << expected.file;
    EXPECT_EQ(cloud->nonfinite_count, expected.nonfinite_count) << expected.file;
    EXPECT_EQ(cloud->zero_count, expected.zero_count) << expected.file;
    Eigen::Vector3d lowest_m = cloud->points_m.front();
    Eigen::Vector3d highest_m = lowest_m;
    for (const Eigen::Vector3d& point_m : cloud->points_m) {
      lowest_m = lowest_m.cwiseMin(point_m);
      highest_m = highest_m.cwiseMax(point_m);
    }
    EXPECT_LE((lowest_m - expected.lowest_m).cwiseAbs().maxCoeff(), 6e-4) << expected.file;
    EXPECT_LE((highest_m - expected.highest_m).cwiseAbs().maxCoeff(), 6e-4) << expected.file;
  }
}

// The same scan was published as PCD and as PLY.
TEST_F(RealFiles, GiveTheSamePointsInTwoFormats) {
  const auto pcd = read_point_cloud(data_ / "interop/ndt_omp/251371071.pcd");
  const auto ply = read_point_cloud(data_ / "interop/small_gicp/source.ply");
  ASSERT_TRUE(pcd.has_value() && ply.has_value());
  EXPECT_EQ(pcd->points_m, ply->points_m);
  EXPECT_EQ(pcd->intensity, ply->intensity);
}

TEST_F(RealFiles, AreRefusedWithTheirCode) {
  struct Refused {
    const char* file;
    ErrorCode code;
  };
  const std::vector<Refused> files = {
      {"lfs_pointers_as_pcd/ascii.pcd", ErrorCode::kGitLfsPointer},
      {"lfs_pointers_as_pcd/bincomp.pcd", ErrorCode::kGitLfsPointer},
      {"las_rs/autzen.las", ErrorCode::kUnsupportedFormat},
      {"las_rs/autzen.laz", ErrorCode::kUnsupportedFormat},
      {"laspy/simple.copc.laz", ErrorCode::kUnsupportedFormat},
      {"mmdet3d/n015-2018-07-24-11-22-45+0800__LIDAR_TOP__1532402927647951.pcd.bin",
       ErrorCode::kUnsupportedFormat},
      {"mrpt_velodyne_pcap/kitti_00_000000.bin.gz", ErrorCode::kUnsupportedFormat},
      {"mrpt_velodyne_pcap/sample_velodyne_hdl32.pcap", ErrorCode::kUnsupportedFormat},
      {"pyntcloud/diamond.npy", ErrorCode::kUnsupportedFormat},
      {"pyntcloud/diamond.npz", ErrorCode::kUnsupportedFormat},
      {"pyntcloud/diamond.xyz", ErrorCode::kUnsupportedFormat},
      {"pyntcloud/diamond.bin", ErrorCode::kTruncatedScan},
      {"pcl_test/brisk_descriptors_gt.pcd", ErrorCode::kMissingField},
      {"pcl_test/stereo_left.pcd", ErrorCode::kMissingField},
  };
  for (const Refused& expected : files) {
    const Result<PointCloudFile> cloud = read_point_cloud(data_ / "interop" / expected.file);
    ASSERT_FALSE(cloud.has_value()) << expected.file;
    EXPECT_EQ(cloud.error().code, expected.code) << to_string(cloud.error());
  }
}

TEST_F(RealFiles, Kitti0005OpensWithoutPosesAtTenScansASecond) {
  RecordingOptions options;
  options.scans = (data_ / "kitti_0005").string();
  options.sensor = "hdl-64e";
  const Result<Recording> recording = open_recording(options, 2);
  ASSERT_TRUE(recording.has_value()) << to_string(recording.error());
  ASSERT_EQ(recording->scans.size(), 154U);
  EXPECT_EQ(recording->scans.back().stamp_ns, 15'300'000'000);
  EXPECT_FALSE(recording->scans.back().T_world_vehicle.has_value());
  const Result<PointCloudFile> first = read_recorded_scan(*recording, 0);
  ASSERT_TRUE(first.has_value()) << to_string(first.error());
  EXPECT_EQ(first->points_m.size(), 123397U);
  EXPECT_EQ(first->zero_count, 1U);
}

TEST_F(RealFiles, MulranTakesTheFirstRowsOfItsWholeRunAndSaysSo) {
  RecordingOptions options;
  const std::filesystem::path folder = data_ / "mulran_kaist03" / "mulran_kaist03";
  options.scans = (folder / "Scans").string();
  options.poses = (folder / "optimized_poses.txt").string();
  options.stamps = (folder / "times.txt").string();
  options.poses_of = "sensor";
  options.sensor = "os1-64";
  const Result<Recording> recording = open_recording(options, 2);
  ASSERT_TRUE(recording.has_value()) << to_string(recording.error());
  ASSERT_EQ(recording->scans.size(), 21U);
  EXPECT_EQ(recording->scans[0].stamp_ns, 1567410201745204700);
  EXPECT_EQ(recording->warnings.size(), 2U);
  // 24 m in keyframes about 1.2 m apart.
  double length_m = 0.0;
  for (std::size_t i = 1; i < recording->scans.size(); ++i) {
    length_m += (recording->scans[i].T_world_vehicle->translation() -
                 recording->scans[i - 1].T_world_vehicle->translation())
                    .norm();
    EXPECT_TRUE(is_rigid(*recording->scans[i].T_world_vehicle));
  }
  EXPECT_NEAR(length_m, 24.0, 1.0);
}

TEST_F(RealFiles, ApolloKeepsTheMillimetresOfUtm) {
  RecordingOptions options;
  const std::filesystem::path folder = data_ / "apollo_sunnyvale_ndt" / "test_data" / "pcds";
  options.scans = folder.string();
  options.poses = (folder / "poses.txt").string();
  options.poses_of = "sensor";
  const Result<Recording> recording = open_recording(options, 2);
  ASSERT_TRUE(recording.has_value()) << to_string(recording.error());
  ASSERT_EQ(recording->scans.size(), 2U);
  EXPECT_EQ(recording->scans[0].stamp_ns, 1223328152391680000);
  const Pose& T_world_sensor = *recording->scans[0].T_world_vehicle;
  const MapFrame frame = frame_near(T_world_sensor.translation(), 64.0);
  const Eigen::Vector3d position_m = rebase(T_world_sensor, {}, frame).translation();
  EXPECT_TRUE(position_m.isApprox(Eigen::Vector3d(60.947978, 56.223859, 33.905676), 1e-9));
  const Result<PointCloudFile> cloud = read_recorded_scan(*recording, 0);
  ASSERT_TRUE(cloud.has_value()) << to_string(cloud.error());
  EXPECT_EQ(cloud->points_m.size() + cloud->nonfinite_count + cloud->zero_count, 99305U);
}

TEST_F(RealFiles, Kitti00TakesItsPosesByFrame) {
  RecordingOptions options;
  options.scans = (data_ / "kitti00_head" / "data").string();
  options.poses = (data_ / "kitti00_head" / "KITTI_00_gt_velodyne_frame.txt").string();
  options.poses_of = "sensor";
  options.sensor = "hdl-64e";
  const Result<Recording> recording = open_recording(options, 2);
  ASSERT_TRUE(recording.has_value()) << to_string(recording.error());
  ASSERT_EQ(recording->scans.size(), 6U);
  EXPECT_NEAR(recording->scans[5].T_world_vehicle->translation().x(), 4.291719, 1e-6);
}

}  // namespace
}  // namespace sightline
