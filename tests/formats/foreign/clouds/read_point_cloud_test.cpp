
#include <zlib.h>

#include <limits>

#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

// zlib's other half packs what our reader unpacks.
std::string gzipped(std::string_view text) {
  constexpr int kGzipWindow = 15 + 16;
  z_stream stream{};
  EXPECT_EQ(
      deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY),
      Z_OK);
  std::string packed(text.size() + 100, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  return packed;
}

struct Refused {
  std::string name;
  std::string content;
  ErrorCode code;
  std::string hint;  // part of the message
};

TEST(PointCloudFile, RecognizesUnsupportedFormatsByContentAndSaysWhatToDo) {
  const std::vector<Refused> cases = {
      {"0.pcd", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n",
       ErrorCode::kGitLfsPointer, "git lfs pull"},
      {"0.bin", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n",
       ErrorCode::kGitLfsPointer, "git lfs pull"},
      {"0.e57", "ASTM-E57 and more", ErrorCode::kUnsupportedFormat, "convert"},
      {"0.zip", "PK\x03\x04 and more", ErrorCode::kUnsupportedFormat, "unpack"},
      {"0.pcap", "\xd4\xc3\xb2\xa1 and more", ErrorCode::kUnsupportedFormat, "pcap"},
      {"0.bag", "#ROSBAG V2.0\n", ErrorCode::kUnsupportedFormat, "name the file itself"},
      {"0.pcapng", "\x0a\x0d\x0d\x0a and more", ErrorCode::kUnsupportedFormat, "editcap"},
      {"0.xyz", "1 2 3\n", ErrorCode::kUnsupportedFormat, "PCD header"},
      {"0.obj", "v 1 2 3\n", ErrorCode::kUnsupportedFormat, "mesh"},
      {"0.stl", "solid thing\n", ErrorCode::kUnsupportedFormat, "mesh"},
      {"0.vtk", "# vtk DataFile Version 3.0\n", ErrorCode::kUnsupportedFormat, "pcl_vtk2pcd"},
      {"0.thing", "1 2 3\n", ErrorCode::kUnsupportedFormat, "convert"},
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

TEST(PointCloudFile, ReadsWhatGzipPackedAndRefusesWhatItDamaged) {
  const std::string scan = as_bytes({1.5F, -2.0F, 3.0F, 0.25F, 4.0F, 5.0F, 6.0F, 0.5F});
  const std::string packed = gzipped(scan);
  const Result<PointCloudFile> cloud = parse_text(packed, "0.bin.gz");
  ASSERT_TRUE(cloud.has_value()) << to_string(cloud.error());
  EXPECT_EQ(cloud->points_m,
            (std::vector<Eigen::Vector3d>{Eigen::Vector3d(1.5, -2.0, 3.0), {4.0, 5.0, 6.0}}));
  expect_every_cut_is_noticed(packed, "0.bin.gz");
  expect_no_damage_crashes(packed, "0.bin.gz");
  const Result<PointCloudFile> nested = parse_text(gzipped(packed), "0.bin.gz");
  ASSERT_FALSE(nested.has_value());
  const Result<PointCloudFile> strange = parse_text(gzipped("ASTM-E57"), "0.e57.gz");
  EXPECT_EQ(strange.error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(strange.error().file, "0.e57.gz");
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

TEST(NuscenesBin, ReadsFiveFloatsAPointByItsNameOrItsRings) {
  std::string scan;
  for (int i = 0; i < 16; ++i) {
    scan += as_bytes({1.5F, 2.5F, static_cast<float>(i + 1), 17.0F, static_cast<float>(i)});
  }
  for (const char* name : {"0.pcd.bin", "0.bin"}) {
    const Result<PointCloudFile> cloud = parse_text(scan, name);
    ASSERT_TRUE(cloud.has_value()) << to_string(cloud.error());
    ASSERT_EQ(cloud->points_m.size(), 16U);
    EXPECT_EQ(cloud->points_m[15], Eigen::Vector3d(1.5, 2.5, 16.0));
    EXPECT_EQ(cloud->intensity[15], 17.0F);
  }
  const Result<PointCloudFile> cut = parse_text(scan.substr(0, 50), "0.pcd.bin");
  EXPECT_EQ(cut.error().code, ErrorCode::kTruncatedScan);
  EXPECT_EQ(cut.error().place, "byte 40");
}

TEST(KittiBin, RefusesWhatCannotBeFourFloatsAPoint) {
  const std::string point = as_bytes({1.5F, 2.5F, 3.5F, 0.5F});
  const Result<PointCloudFile> cut = parse_text(point + point.substr(0, 9), "0.bin");
  EXPECT_EQ(cut.error().code, ErrorCode::kTruncatedScan);
  EXPECT_EQ(cut.error().place, "byte 16");
  EXPECT_EQ(parse_text(point + as_bytes({1e9F, 0.0F, 0.0F, 0.0F}), "0.bin").error().code,
            ErrorCode::kUnsupportedFormat);
}

}  // namespace
}  // namespace sightline
