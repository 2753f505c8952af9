#include "formats/foreign/clouds/point_cloud_file.h"

#include <cstdlib>
#include <limits>

#include "formats/base/random.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

PointCloudFile with_times(const std::vector<double>& times) {
  PointCloudFile cloud;
  cloud.points_m.resize(times.size(), Eigen::Vector3d::UnitX());
  set_point_times(times, cloud);
  return cloud;
}

TEST(PointTimes, TakeTheUnitInWhichTheScanLastsBetweenTwoMillisecondsAndTwoSeconds) {
  const std::vector<std::int32_t> expected = {0, 40'000'000, 100'000'000};
  EXPECT_EQ(with_times({0.0, 0.04, 0.1}).time_offset_ns, expected);    // Velodyne's driver: s
  EXPECT_EQ(with_times({0.0, 40.0, 100.0}).time_offset_ns, expected);  // ms
  EXPECT_EQ(with_times({0.0, 4e4, 1e5}).time_offset_ns, expected);     // us
  EXPECT_EQ(with_times({0.0, 4e7, 1e8}).time_offset_ns, expected);     // Ouster, Livox: ns
  EXPECT_FALSE(with_times({0.0, 0.04, 0.1}).time_origin_ns.has_value());
  // Some drivers count back from the end.
  EXPECT_EQ(with_times({-0.1, 0.0}).time_offset_ns, (std::vector<std::int32_t>{-100'000'000, 0}));
}

TEST(PointTimes, FarFromZeroAreTimesOfAClock) {
  const PointCloudFile cloud = with_times({1567410201.75, 1567410201.80, 1567410201.70});
  // A double carries 2e-7 s here.
  ASSERT_TRUE(cloud.time_origin_ns.has_value());
  EXPECT_LE(std::abs(*cloud.time_origin_ns - 1567410201700000000), 300);
  ASSERT_EQ(cloud.time_offset_ns.size(), 3U);
  EXPECT_NEAR(cloud.time_offset_ns[0], 50'000'000, 300);
  EXPECT_NEAR(cloud.time_offset_ns[1], 100'000'000, 300);
  EXPECT_EQ(cloud.time_offset_ns[2], 0);
  EXPECT_EQ(with_times({1.5674102017e18, 1.5674102018e18}).time_offset_ns.back(), 100'000'000);
}

TEST(PointTimes, ThatSayNothingAreLeftOutAndThoseThatMakeNoSenseAreFlagged) {
  EXPECT_FALSE(with_times({7.0, 7.0}).has_unclear_times);
  EXPECT_TRUE(with_times({7.0, 7.0}).time_offset_ns.empty());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<double>& times :
       {std::vector<double>{0.0, 1e-4}, {0.0, nan}, {0.0, 1e12}, {-1e300, 1e300}}) {
    const PointCloudFile cloud = with_times(times);
    EXPECT_TRUE(cloud.time_offset_ns.empty());
    EXPECT_TRUE(cloud.has_unclear_times);
  }
}

// x y z as float, t as whole nanoseconds: the second point is no return.
TEST(PointTimes, OfAPcdGoWithThePointsThatAreKept) {
  const std::string fields =
      "VERSION 0.7\nFIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n"
      "POINTS 3\n";
  const std::string ascii = fields + "DATA ascii\n1 2 3 0\n0 0 0 20000000\n4 5 6 90000000\n";
  const auto point = [](float x, float y, float z, std::uint32_t t) {
    return as_bytes({x, y, z}) + as_bytes({t});
  };
  const std::string binary = fields + "DATA binary\n" + point(1, 2, 3, 0) +
                             point(0, 0, 0, 20'000'000) + point(4, 5, 6, 90'000'000);
  for (const std::string& file : {ascii, binary}) {
    const PointCloudFile cloud = value_of(parse_text(file, "0.pcd"));
    EXPECT_EQ(cloud.points_m.size(), 2U);
    EXPECT_EQ(cloud.time_offset_ns, (std::vector<std::int32_t>{0, 90'000'000}));
  }
}

TEST(PointTimes, AreTheSameInEveryUnit) {
  Random random(4);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> times_s(20);
    const double span_s = random.uniform(0.01, 1.0);
    for (double& time_s : times_s) time_s = random.uniform(0.0, span_s);
    const std::vector<std::int32_t> expected = with_times(times_s).time_offset_ns;
    for (const double unit : {1e3, 1e6, 1e9}) {
      std::vector<double> times = times_s;
      for (double& time : times) time *= unit;
      const std::vector<std::int32_t> found = with_times(times).time_offset_ns;
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1);
    }
  }
}

}  // namespace
}  // namespace sightline
