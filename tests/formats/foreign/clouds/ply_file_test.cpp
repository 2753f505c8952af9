#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <algorithm>

#include "formats/base/random.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using enum ErrorCode;
ErrorCode code_of(const std::string& text) { return code_of(parse_text(text, "a.ply")); }

std::string header(std::string_view format, std::string_view elements) {
  return std::string("ply\nformat ")
      .append(format)
      .append(" 1.0\ncomment by hand\n")
      .append(elements)
      .append("end_header\n");
}

constexpr std::string_view kXyz =
    "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";

template <class T>
std::string turned(T value) {
  std::string bytes = as_bytes({value});
  std::ranges::reverse(bytes);
  return bytes;
}

TEST(PlyFile, ReadsWhatPclWrites) {
  const ScratchFolder folder;
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    pcl::PointCloud<pcl::PointXYZI> cloud;
    for (std::uint64_t i = 0, count = 1 + random.below(50); i < count; ++i) {
      pcl::PointXYZI point;
      point.x = static_cast<float>(random.uniform(-90.0, 90.0));
      point.y = static_cast<float>(random.uniform(-90.0, 90.0));
      point.z = static_cast<float>(random.uniform(-3.0, 15.0));
      point.intensity = static_cast<float>(random.below(256));
      cloud.push_back(point);
    }
    const bool is_binary = round % 2 == 0;
    ASSERT_EQ(pcl::io::savePLYFile((folder / "a.ply").string(), cloud, is_binary), 0);
    const PointCloudFile read = value_of(read_point_cloud(folder / "a.ply"));
    ASSERT_EQ(read.points_m.size(), cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      // PCL writes text with 8 digits.
      const double tolerance_m = is_binary ? 0.0 : 1e-5;
      EXPECT_NEAR(read.points_m[i].x(), cloud[i].x, tolerance_m);
      EXPECT_NEAR(read.points_m[i].y(), cloud[i].y, tolerance_m);
      EXPECT_NEAR(read.points_m[i].z(), cloud[i].z, tolerance_m);
      EXPECT_EQ(read.intensity[i], cloud[i].intensity);
    }
  }
}

TEST(PlyFile, ReadsBothByteOrdersAndEveryTypeAlike) {
  const std::string elements =
      "element vertex 1\nproperty uchar red\nproperty double x\nproperty short y\n"
      "property int z\nproperty float intensity\n";
  const std::string little = header("binary_little_endian", elements) + "r" +
                             as_bytes({588348.947978}) + as_bytes<std::int16_t>({-300}) +
                             as_bytes<std::int32_t>({70000}) + as_bytes({0.25F});
  const std::string big = header("binary_big_endian", elements) + "r" + turned(588348.947978) +
                          turned(std::int16_t{-300}) + turned(std::int32_t{70000}) + turned(0.25F);
  for (const std::string& text : {little, big}) {
    const PointCloudFile cloud = value_of(parse_text(text, "a.ply"));
    EXPECT_EQ(cloud.points_m.at(0), Eigen::Vector3d(588348.947978, -300, 70000));
    EXPECT_EQ(cloud.intensity.at(0), 0.25F);
  }
}

TEST(PlyFile, WalksThroughFacesBeforeAndBehindTheVertices) {
  const std::string elements = std::string("element face 1\nproperty list uchar int index\n")
                                   .append(kXyz)
                                   .append("element face 2\nproperty list uchar int index\n");
  const std::string text =
      header("ascii", elements) + "3 0 1 2\n1 2 3\n4 5 6\n3 0 1 1\n4 0 1 1 0\n";
  EXPECT_EQ(value_of(parse_text(text, "a.ply")).points_m.at(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(code_of(header("ascii", elements) + "3 0 1 2\n1 2 3\n4 5 6\n3 0 1 1\n4 0 1 1\n"),
            kTruncatedScan);
}

TEST(PlyFile, RefusesHeadersThatLieOrMakeNoSense) {
  const std::string points = as_bytes({1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F});
  const std::string good = header("binary_little_endian", kXyz);
  EXPECT_TRUE(parse_text(good + points, "a.ply").has_value());
  EXPECT_EQ(code_of(good + points + "more"), kMalformedHeader);
  EXPECT_EQ(code_of(good + points.substr(4)), kTruncatedScan);
  EXPECT_EQ(code_of(header("binary_middle_endian", kXyz)), kMalformedHeader);
  EXPECT_EQ(code_of(header("ascii",
                           "element vertex 0\nproperty float x\nproperty float y\n"
                           "property float z\n")),
            kEmptyScan);
  EXPECT_EQ(code_of(header("ascii", "element vertex 1\nproperty float x\n")), kMissingField);
  EXPECT_EQ(code_of(header("ascii", "element vertex 1\nproperty quad x\n")), kMalformedHeader);
  EXPECT_EQ(code_of(header("ascii", "property float x\n")), kMalformedHeader);
  EXPECT_EQ(code_of(header("ascii", "element vertex many\n")), kMalformedHeader);
  EXPECT_EQ(code_of("ply\nend_header\n"), kMalformedHeader);
  EXPECT_EQ(code_of(header("binary_little_endian",
                           "element vertex 18446744073709551615\nproperty float x\n"
                           "property float y\nproperty float z\n") +
                    points),
            kTruncatedScan);
  EXPECT_EQ(code_of(header("ascii", kXyz) + "1 2 3\n4 5 6 7\n"), kMalformedText);
}

TEST(PlyFile, RefusesWhatCouldBeReadInTwoWays) {
  EXPECT_EQ(code_of(header("ascii",
                           "element vertex 1\nproperty float x\nproperty float y\n"
                           "property float z\nproperty float x\n") +
                    "1 2 3 4\n"),
            kMalformedHeader);
  EXPECT_EQ(code_of("ply\nformat binary_big_endian 1.0\nformat ascii 1.0\n" + std::string(kXyz) +
                    "end_header\n1 2 3\n4 5 6\n"),
            kMalformedHeader);
  const std::string faces = std::string(kXyz).append("element face 1\nproperty list uchar int i\n");
  EXPECT_EQ(code_of(header("ascii", faces) + "1 2 3\n4 5 6\n1.5 0\n"), kTruncatedScan);
}

TEST(PlyFile, IsRefusedOrFlaggedWhereverItIsCutAndNeverCrashesWhenDamaged) {
  const std::string faces =
      std::string(kXyz).append("element face 1\nproperty list uchar int vertex_indices\n");
  const std::string points = as_bytes({1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F});
  for (const std::string& whole :
       {header("ascii", kXyz) + "1.25 2.5 3.125\n4 5.5 6.75\n",
        header("binary_little_endian", faces) + points + "\x03" + as_bytes<std::int32_t>({0, 1, 1}),
        header("binary_big_endian", kXyz) + points}) {
    expect_every_cut_is_noticed(whole, "a.ply");
    expect_no_damage_crashes(whole, "a.ply");
  }
}

}  // namespace
}  // namespace sightline
