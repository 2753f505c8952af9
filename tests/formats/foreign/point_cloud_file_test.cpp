#include "formats/foreign/point_cloud_file.h"

#include <limits>

#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

struct Refused {
  std::string name;
  std::string content;
  ErrorCode code;
  std::string hint;  // part of the message
};

TEST(PointCloudFile, TellsStrangersByTheirContentAndSaysWhatToDo) {
  const std::string las = "LASF" + std::string(123, '\0');
  std::string laz = las;
  laz[104] = '\x83';
  const std::vector<Refused> cases = {
      {"0.pcd", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n",
       ErrorCode::kGitLfsPointer, "git lfs pull"},
      {"0.bin", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n",
       ErrorCode::kGitLfsPointer, "git lfs pull"},
      {"0.las", las, ErrorCode::kUnsupportedFormat, "LAS is not read; convert"},
      {"0.pcd", laz, ErrorCode::kUnsupportedFormat, "LAZ is not read; convert"},
      {"0.e57", "ASTM-E57 and more", ErrorCode::kUnsupportedFormat, "convert"},
      {"0.zip", "PK\x03\x04 and more", ErrorCode::kUnsupportedFormat, "unpack"},
      {"0.pcd", std::string("\x1f\x8b\x08\x00\x00", 5), ErrorCode::kUnsupportedFormat, "gunzip"},
      {"0.pcap", "\xd4\xc3\xb2\xa1 and more", ErrorCode::kUnsupportedFormat, "pcap"},
      {"0.xyz", "1 2 3\n", ErrorCode::kUnsupportedFormat, "convert"},
      {"0.pcd", "", ErrorCode::kEmptyScan, "empty"},
  };
  for (const Refused& refused : cases) {
    const Result<PointCloudFile> cloud = parse_text(refused.content, refused.name);
    ASSERT_FALSE(cloud.has_value()) << refused.name;
    EXPECT_EQ(cloud.error().code, refused.code) << to_string(cloud.error());
    EXPECT_NE(cloud.error().message.find(refused.hint), std::string::npos)
        << to_string(cloud.error());
    EXPECT_EQ(cloud.error().file, refused.name);
    EXPECT_EQ(cloud.error().place, "byte 0");
  }
}

TEST(PointCloudFile, SaysWhichFileIsMissing) {
  const Result<PointCloudFile> cloud = read_point_cloud("/nowhere/0.pcd");
  ASSERT_FALSE(cloud.has_value());
  EXPECT_EQ(cloud.error().code, ErrorCode::kFileNotFound);
  EXPECT_EQ(cloud.error().file, "/nowhere/0.pcd");
}

TEST(KittiBin, ReadsFourFloatsAPointAndCountsWhatIsNoReturn) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Result<PointCloudFile> cloud = parse_text(
      as_bytes({1.5F, -2.0F, 3.0F, 0.25F, 0.0F, 0.0F, 0.0F, 0.1F, nan, 1.0F, 1.0F, 0.0F}), "0.bin");
  ASSERT_TRUE(cloud.has_value()) << to_string(cloud.error());
  EXPECT_EQ(cloud->points_m, std::vector<Eigen::Vector3d>{Eigen::Vector3d(1.5, -2.0, 3.0)});
  EXPECT_EQ(cloud->intensity, std::vector<float>{0.25F});
  EXPECT_EQ(cloud->nonfinite_count, 1U);
  EXPECT_EQ(cloud->zero_count, 1U);
}

TEST(KittiBin, RefusesWhatCannotBeFourFloatsAPoint) {
  std::string nuscenes;
  for (int i = 0; i < 16; ++i) {
    nuscenes += as_bytes({1.5F, 2.5F, 3.5F, 17.0F, static_cast<float>(i)});
  }
  EXPECT_EQ(parse_text(nuscenes, "0.pcd.bin").error().code, ErrorCode::kUnsupportedFormat);
  const std::string point = as_bytes({1.5F, 2.5F, 3.5F, 0.5F});
  const Result<PointCloudFile> cut = parse_text(point + point.substr(0, 9), "0.bin");
  EXPECT_EQ(cut.error().code, ErrorCode::kTruncatedScan);
  EXPECT_EQ(cut.error().place, "byte 16");
  EXPECT_EQ(parse_text(point + as_bytes({1e9F, 0.0F, 0.0F, 0.0F}), "0.bin").error().code,
            ErrorCode::kUnsupportedFormat);
}

}  // namespace
}  // namespace sightline
