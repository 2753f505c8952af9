#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/maps/apollo_map.h"
#include "formats/foreign/recording/open_recording.h"
#include "tests/formats/foreign/float_layouts.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/real_data.h"
#include "tests/support/value_of.h"

// Files that other people's programs wrote. They are not part of the project (tests/README.md).

namespace sightline {
namespace {

TEST(RealFiles, GiveTheSamePointsInTwoFormats) {
  const RealData data = real_data("interop");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const auto pcd = read_point_cloud(data.folder / "ndt_omp/251371071.pcd");
  const auto ply = read_point_cloud(data.folder / "small_gicp/source.ply");
  ASSERT_TRUE(pcd.has_value() && ply.has_value());
  EXPECT_EQ(pcd->points_m, ply->points_m);
  EXPECT_EQ(pcd->intensity, ply->intensity);
}

TEST(RealFiles, Kitti0005OpensWithoutPosesAtTenScansASecond) {
  const RealData data = real_data("kitti_0005");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  RecordingOptions options;
  options.scans = data.folder.string();
  options.sensor = "hdl-64e";
  const Recording recording = value_of(open_recording(options, 2));
  ASSERT_EQ(recording.scans.size(), 154U);
  EXPECT_EQ(recording.scans.back().stamp_ns, 15'300'000'000);
  EXPECT_FALSE(recording.scans.back().T_world_vehicle.has_value());
  const PointCloudFile first = value_of(read_recorded_scan(recording, 0));
  EXPECT_EQ(first.points_m.size(), 123397U);
  EXPECT_EQ(first.zero_count, 1U);
}

TEST(RealFiles, MulranTakesTheFirstRowsOfItsWholeRunAndSaysSo) {
  const RealData data = real_data("mulran_kaist03");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  RecordingOptions options;
  const std::filesystem::path folder = data.folder / "mulran_kaist03";
  options.scans = (folder / "Scans").string();
  options.poses = (folder / "optimized_poses.txt").string();
  options.stamps = (folder / "times.txt").string();
  options.poses_of = PosesOf::kSensor;
  options.sensor = "os1-64";
  const Recording recording = value_of(open_recording(options, 2));
  ASSERT_EQ(recording.scans.size(), 21U);
  EXPECT_EQ(recording.scans[0].stamp_ns, 1567410201745204700);
  EXPECT_EQ(recording.warnings.size(), 2U);
  // 24 m in keyframes about 1.2 m apart.
  double length_m = 0.0;
  for (std::size_t i = 1; i < recording.scans.size(); ++i) {
    length_m += (recording.scans[i].T_world_vehicle->translation() -
                 recording.scans[i - 1].T_world_vehicle->translation())
                    .norm();
    EXPECT_TRUE(is_rigid(*recording.scans[i].T_world_vehicle));
  }
  EXPECT_NEAR(length_m, 24.0, 1.0);
}

TEST(RealFiles, ApolloKeepsTheMillimetresOfUtm) {
  const RealData data = real_data("apollo_sunnyvale_ndt");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  RecordingOptions options;
  const std::filesystem::path folder = data.folder / "test_data" / "pcds";
  options.scans = folder.string();
  options.poses = (folder / "poses.txt").string();
  options.poses_of = PosesOf::kSensor;
  const Recording recording = value_of(open_recording(options, 2));
  ASSERT_EQ(recording.scans.size(), 2U);
  EXPECT_EQ(recording.scans[0].stamp_ns, 1223328152391680000);
  const Pose& T_world_sensor = *recording.scans[0].T_world_vehicle;
  const MapFrame frame = frame_near(T_world_sensor.translation(), 64.0);
  const Eigen::Vector3d position_m = rebase(T_world_sensor, {}, frame).translation();
  EXPECT_TRUE(position_m.isApprox(Eigen::Vector3d(60.947978, 56.223859, 33.905676), 1e-9));
  const PointCloudFile cloud = value_of(read_recorded_scan(recording, 0));
  EXPECT_EQ(cloud.points_m.size() + cloud.nonfinite_count + cloud.zero_count, 99305U);
}

TEST(RealFiles, ApollosNdsAreThoseOfItsNodes) {
  const RealData data = real_data("apollo_sunnyvale_ndt");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const std::filesystem::path folder = data.folder / "test_data" / "ndt_map";
  ASSERT_TRUE(is_apollo_map(folder));
  EXPECT_EQ(list_apollo_map(folder)->size(), 9U);
  const ForeignNds map = value_of(open_apollo_map(folder, 2));
  ASSERT_TRUE(validate(map).has_value());
  EXPECT_TRUE(map.warnings.empty()) << map.warnings.front();
  EXPECT_EQ(map.world, "utm:10N");
  EXPECT_EQ(map.nds.size() + map.single_point_count, 20584U);
  EXPECT_EQ(map.single_point_count, 2588U);
  const auto count_of_least = [&](std::uint32_t least) {
    return std::ranges::count_if(map.nds,
                                 [&](const ForeignNd& nd) { return nd.point_count >= least; });
  };
  EXPECT_EQ(count_of_least(6), 13611);
  EXPECT_EQ(count_of_least(10), 11386);
  // Column 33, row 0, altitude -30 of node (32353, 4596); heights are cut towards zero.
  const CellKey key{4596 * 128 + 33, 32353 * 128, -31};
  const auto nd = std::ranges::find(map.nds, key, &ForeignNd::key_world);
  ASSERT_NE(nd, map.nds.end());
  EXPECT_EQ(nd->point_count, 107U);
  EXPECT_TRUE(nd->mean_in_cell_m.isApprox(
      Eigen::Vector3d(0.7335839868, 0.4302841127, 1.0 - 0.4646438062), 1e-9));
  EXPECT_NEAR(nd->covariance_m2(0, 0), (0.5490189195 - 0.7335839868 * 0.7335839868) * 107 / 106,
              1e-8);
}

TEST(RealFiles, Kitti00TakesItsPosesByFrame) {
  const RealData data = real_data("kitti00_head");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  RecordingOptions options;
  options.scans = (data.folder / "data").string();
  options.poses = (data.folder / "KITTI_00_gt_velodyne_frame.txt").string();
  options.poses_of = PosesOf::kSensor;
  options.sensor = "hdl-64e";
  const Recording recording = value_of(open_recording(options, 2));
  ASSERT_EQ(recording.scans.size(), 6U);
  EXPECT_NEAR(recording.scans[5].T_world_vehicle->translation().x(), 4.291719, 1e-6);
}

// Laid out as people do without a header, each scan speaks for its number of floats a point.
void expect_right_counts(const std::filesystem::path& file) {
  const PointCloudFile cloud = value_of(read_point_cloud(file));
  for (const std::string& layout : kLayouts) {
    EXPECT_EQ(counts_text(fitting(float_file(cloud.points_m, layout))),
              std::to_string(layout.size()))
        << layout << " of " << file;
  }
}

TEST(RealFiles, SpeakForTheirNumberOfFloatsAPointInEveryLayout) {
  const RealData data = real_data("kitti00_head");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  for (int i = 0; i < 6; ++i) {
    expect_right_counts(data.folder / "data" / ("00000" + std::to_string(i) + ".bin"));
  }
  const RealData street = real_data("kitti_0005");
  for (const char* name : {"0000000000.pcd", "0000000077.pcd", "0000000153.pcd"}) {
    if (street.missing.empty()) expect_right_counts(street.folder / name);
  }
  const RealData interop = real_data("interop");
  if (!interop.missing.empty()) return;
  expect_right_counts(interop.folder / "ndt_omp/251370668.pcd");
  expect_right_counts(interop.folder / "mmdet3d/000008.bin");
  expect_right_counts(interop.folder /
                      "mmdet3d/n015-2018-07-24-11-22-45+0800__LIDAR_TOP__1532402927647951.pcd.bin");
}

}  // namespace
}  // namespace sightline
