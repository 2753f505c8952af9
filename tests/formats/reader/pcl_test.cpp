#include "formats/reader/pcl.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace sightline {
namespace {

RangeAnswer answer_of(double range_m) {
  RangeAnswer answer;
  answer.range_m = range_m;
  return answer;
}

TEST(PclCrop, KeepsWhatIsWithinTheSlantRangeWithAllItsFields) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  pcl::PointCloud<pcl::PointXYZI> scan;
  scan.header.frame_id = "lidar";
  scan.header.stamp = 17;
  scan.sensor_origin_.x() = 3.0F;
  const auto add = [&](float x, float y, float z, float intensity) {
    pcl::PointXYZI point;
    point.x = x;
    point.y = y;
    point.z = z;
    point.intensity = intensity;
    scan.push_back(point);
  };
  add(3.0F, 0.0F, 4.0F, 1.0F);  // 5 m away, 3 m along the ground
  add(0.0F, 4.0F, 3.1F, 2.0F);
  add(kNan, 0.0F, 0.0F, 3.0F);
  add(-1.0F, 0.0F, std::numeric_limits<float>::infinity(), 4.0F);
  add(0.0F, -5.0F, 0.0F, 5.0F);
  const pcl::PointCloud<pcl::PointXYZI> cropped = crop(scan, answer_of(5.0));
  ASSERT_EQ(cropped.size(), 2u);
  EXPECT_EQ(cropped[0].intensity, 1.0F);
  EXPECT_EQ(cropped[1].intensity, 5.0F);
  EXPECT_EQ(cropped.width, 2u);
  EXPECT_EQ(cropped.height, 1u);
  EXPECT_TRUE(cropped.is_dense);
  EXPECT_EQ(cropped.header.frame_id, "lidar");
  EXPECT_EQ(cropped.header.stamp, 17u);
  EXPECT_EQ(cropped.sensor_origin_.x(), 3.0F);
}

TEST(PclCrop, MeasuresFromWhereTheSensorIs) {
  pcl::PointCloud<pcl::PointXYZ> scan;
  scan.push_back({10.0F, 0.0F, 0.0F});
  scan.push_back({-1.0F, 0.0F, 0.0F});
  const pcl::PointCloud<pcl::PointXYZ> cropped =
      crop(scan, answer_of(6.0), Eigen::Vector3d(8.0, 0.0, 2.0));
  ASSERT_EQ(cropped.size(), 1u);
  EXPECT_EQ(cropped[0].x, 10.0F);
  EXPECT_TRUE(crop(scan, answer_of(0.5)).empty());
}

TEST(PclCrop, KeepsNoLessAtALongerRange) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> coordinate(-40.0F, 40.0F);
  pcl::PointCloud<pcl::PointXYZ> scan;
  for (int i = 0; i < 2000; ++i) {
    const float x = coordinate(random);
    const float y = coordinate(random);
    scan.push_back({x, y, 0.2F * coordinate(random)});
  }
  std::size_t before = 0;
  for (double range_m = 5.0; range_m <= 60.0; range_m += 5.0) {
    const pcl::PointCloud<pcl::PointXYZ> cropped = crop(scan, answer_of(range_m));
    EXPECT_GT(cropped.size(), before);
    before = cropped.size();
    for (const pcl::PointXYZ& p : cropped) {
      ASSERT_LE(p.getVector3fMap().cast<double>().norm(), range_m);
    }
    if (range_m == 60.0) {
      EXPECT_EQ(cropped.size(), scan.size());
    }
  }
}

}  // namespace
}  // namespace sightline
