#include "formats/foreign/clouds/read_point_cloud.h"

#include <zlib.h>

#include <chrono>
#include <cstdlib>
#include <limits>

#include "formats/base/random.h"
#include "formats/foreign/clouds/point_cloud_file.h"
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

TEST(PointTimes, OfFewDifferentValuesAreFlagged) {
  std::vector<double> times(2000);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = i < 1000 ? 0.0 : 0.064;
  EXPECT_TRUE(with_times(times).has_unclear_times);
  EXPECT_TRUE(with_times(times).time_offset_ns.empty());
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = 1e-3 * static_cast<double>(i / 100);
  EXPECT_EQ(with_times(times).time_offset_ns.back(), 19'000'000) << "twenty packets";
}

// Of a surface it is small; FAST-LIO keeps milliseconds in it.
TEST(PointTimes, AreMillisecondsInCurvatureUnlessAnotherFieldHasThem) {
  const auto read = [](const std::string& fields, const std::string& rows) {
    return value_of(parse_text("VERSION 0.7\nFIELDS x y z " + fields +
                                   "\nSIZE 4 4 4 4 4\nTYPE F F F F F\nCOUNT 1 1 1 1 1\nWIDTH 2\n"
                                   "HEIGHT 1\nPOINTS 2\nDATA ascii\n" +
                                   rows,
                               "0.pcd"));
  };
  const PointCloudFile times = read("i curvature", "1 2 3 9 0\n4 5 6 9 99.5\n");
  EXPECT_EQ(times.time_offset_ns, (std::vector<std::int32_t>{0, 99'500'000}));
  const PointCloudFile surface = read("i curvature", "1 2 3 9 0.01\n4 5 6 9 0.3\n");
  EXPECT_TRUE(surface.time_offset_ns.empty());
  EXPECT_FALSE(surface.has_unclear_times);
  const PointCloudFile both = read("time curvature", "1 2 3 0 0.1\n4 5 6 0.05 0.2\n");
  EXPECT_EQ(both.time_offset_ns, (std::vector<std::int32_t>{0, 50'000'000}));
}

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

using enum ErrorCode;

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
       kGitLfsPointer, "git lfs pull"},
      {"0.bin", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n",
       kGitLfsPointer, "git lfs pull"},
      {"0.e57", "ASTM-E57 and more", kUnsupportedFormat, "convert"},
      {"0.zip", "PK\x03\x04 and more", kUnsupportedFormat, "unpack"},
      {"0.pcap", "\xd4\xc3\xb2\xa1 and more", kUnsupportedFormat, "pcap"},
      {"0.bag", "#ROSBAG V2.0\n", kUnsupportedFormat, "name the file itself"},
      {"0.pcapng", "\x0a\x0d\x0d\x0a and more", kUnsupportedFormat, "name the file itself"},
      {"0.xyz", "1 2 3\n", kUnsupportedFormat, "PCD header"},
      {"0.obj", "v 1 2 3\n", kUnsupportedFormat, "mesh"},
      {"0.stl", "solid thing\n", kUnsupportedFormat, "mesh"},
      {"0.vtk", "# vtk DataFile Version 3.0\n", kUnsupportedFormat, "pcl_vtk2pcd"},
      {"0.thing", "1 2 3\n", kUnsupportedFormat, "convert"},
      {"0.pcd", "", kEmptyScan, "empty"},
  };
  for (const Refused& refused : cases) {
    const Error error = failure_of(parse_text(refused.content, refused.name), refused.name);
    EXPECT_EQ(error.code, refused.code) << to_string(error);
    EXPECT_THAT(error.message, HasSubstr(refused.hint)) << to_string(error);
    EXPECT_EQ(error.file, refused.name);
    EXPECT_EQ(error.place, "byte 0");
  }
}

const std::string kTextScan =
    "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n1.5 -2 3\n4 5 6\n";
const std::vector<Eigen::Vector3d> kTextPoints = {Eigen::Vector3d(1.5, -2.0, 3.0), {4.0, 5.0, 6.0}};

TEST(PointCloudFile, ReadsWhatGzipPackedAndRefusesWhatItDamaged) {
  const std::string packed = gzipped(kTextScan);
  EXPECT_EQ(value_of(parse_text(packed, "0.pcd.gz")).points_m, kTextPoints);
  expect_every_cut_is_noticed(packed, "0.pcd.gz");
  expect_no_damage_crashes(packed, "0.pcd.gz");
  ASSERT_FALSE(parse_text(gzipped(packed), "0.pcd.gz").has_value());
  const Result<PointCloudFile> strange = parse_text(gzipped("ASTM-E57"), "0.e57.gz");
  EXPECT_EQ(strange.error().code, kUnsupportedFormat);
  EXPECT_EQ(strange.error().file, "0.e57.gz");
}

// As `pigz -i`, `bgzip` and `cat a.gz b.gz` write it.
TEST(PointCloudFile, ReadsAllMembersOfAGzip) {
  std::string packed = gzipped("");
  for (std::size_t at = 0; at < kTextScan.size(); at += 7)
    packed += gzipped(kTextScan.substr(at, 7));
  EXPECT_EQ(value_of(parse_text(packed, "0.pcd.gz")).points_m, kTextPoints);
  expect_every_cut_is_noticed(packed, "0.pcd.gz");
}

// A member without content has 20 bytes, and no MiB is cleared for it.
TEST(PointCloudFile, ReadsAGzipInTheTimeOfItsSizeHoweverManyMembersItHas) {
  std::string packed = gzipped(kTextScan);
  const std::string empty = gzipped("");
  for (int i = 0; i < 1'000'000; ++i) packed += empty;
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(parse_text(packed, "0.pcd.gz").has_value());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
}

TEST(PointCloudFile, RefusesWhatLiesBehindAGzipUnlessItIsPadding) {
  const std::string packed = gzipped(kTextScan);
  EXPECT_TRUE(parse_text(packed + std::string(512, '\0'), "0.pcd.gz").has_value());
  std::string damaged = packed + packed;
  damaged[packed.size()] ^= 1;
  for (const std::string& whole : {packed + "more", damaged, packed + packed.substr(0, 2)}) {
    const Error error = failure_of(parse_text(whole, "0.pcd.gz"));
    EXPECT_EQ(error.code, kMalformedHeader);
    EXPECT_EQ(error.place, "byte " + std::to_string(packed.size()));
  }
}

TEST(PointCloudFile, SaysWhichFileIsMissing) {
  const Error error = failure_of(read_point_cloud("/nowhere/0.pcd"));
  EXPECT_EQ(error.code, kFileNotFound);
  EXPECT_EQ(error.file, "/nowhere/0.pcd");
}

const FloatColumns kKitti;

TEST(FloatBin, ReadsFourFloatsAPointAndCountsWhatIsNoReturn) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const PointCloudFile cloud = value_of(parse_text(
      as_bytes({1.5F, -2.0F, 3.0F, 0.25F, 0.0F, 0.0F, 0.0F, 0.1F, nan, 1.0F, 1.0F, 0.0F}), "0.bin",
      kKitti));
  EXPECT_EQ(cloud.points_m, std::vector<Eigen::Vector3d>{Eigen::Vector3d(1.5, -2.0, 3.0)});
  EXPECT_EQ(cloud.intensity, std::vector<float>{0.25F});
  EXPECT_EQ(cloud.nonfinite_count, 1U);
  EXPECT_EQ(cloud.zero_count, 1U);
  EXPECT_EQ(cloud.float_count, 4U);
}

TEST(FloatBin, ReadsTheColumnsThatItIsGiven) {
  const std::string row = as_bytes({0.5F, 7.0F, 3.0F, 2.0F, 1.0F, 0.01F});
  const std::string next = as_bytes({0.75F, 8.0F, 6.0F, 5.0F, 4.0F, 0.09F});
  const PointCloudFile cloud =
      value_of(parse_text(row + next, "0.bin", *parse_float_columns("intensity ring z y x time")));
  EXPECT_EQ(cloud.points_m, (std::vector<Eigen::Vector3d>{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}}));
  EXPECT_EQ(cloud.intensity, (std::vector<float>{0.5F, 0.75F}));
  ASSERT_EQ(cloud.time_offset_ns.size(), 2U);
  EXPECT_NEAR(cloud.time_offset_ns[1], 90'000'000, 10);
}

// Each file is as long as so many points of 4 floats.
TEST(FloatBin, IsNotReadAsFourFloatsWhereItHasOthers) {
  for (const std::size_t columns : {3U, 4U, 5U, 6U, 8U}) {
    const PointCloudFile cloud = value_of(parse_text(float_spiral(columns), "0.bin"), columns);
    EXPECT_EQ(cloud.float_count, columns);
    ASSERT_EQ(cloud.points_m.size(), 1600U) << columns;
    EXPECT_NEAR(cloud.points_m[1599].z(), 1.899, 1e-6) << columns;
  }
}

TEST(FloatBin, IsRefusedWhereNothingOrTooMuchFits) {
  const Error few = failure_of(parse_text(float_spiral(4, 6), "0.bin"));
  EXPECT_EQ(few.code, kUnsupportedFormat);
  EXPECT_THAT(few.message, HasSubstr("3 or 4 or 6 or 8"));
  EXPECT_THAT(few.message, HasSubstr("`columns`"));
  std::string image;
  for (int i = 0; i < 4000; ++i)
    image += as_bytes({10.0F + std::sin(0.01F * static_cast<float>(i))});
  EXPECT_EQ(parse_text(image, "0.bin").error().code, kUnsupportedFormat);
  // Five floats a point, and not a whole number of them.
  const Result<PointCloudFile> cut = parse_text(float_spiral(5).substr(0, 31984), "0.bin");
  EXPECT_EQ(cut.error().code, kTruncatedScan);
  EXPECT_EQ(cut.error().place, "byte 31980");
}

TEST(FloatBin, TakesFiveFloatsWhereTheNameIsOneOfNuscenes) {
  const std::string scan = float_spiral(5, 20);
  EXPECT_EQ(parse_text(scan, "0.bin").error().code, kUnsupportedFormat);
  EXPECT_EQ(value_of(parse_text(scan, "0.pcd.bin")).points_m.size(), 20U);
  EXPECT_EQ(parse_text(float_spiral(4), "0.pcd.bin")->points_m.size(), 1600U);
  const Result<PointCloudFile> cut = parse_text(scan.substr(0, 50), "0.pcd.bin");
  EXPECT_EQ(cut.error().code, kTruncatedScan);
  EXPECT_EQ(cut.error().place, "byte 40");
}

TEST(FloatBin, RefusesWhatCannotBeTheGivenColumns) {
  const std::string point = as_bytes({1.5F, 2.5F, 3.5F, 0.5F});
  const Result<PointCloudFile> cut = parse_text(point + point.substr(0, 9), "0.bin", kKitti);
  EXPECT_EQ(cut.error().code, kTruncatedScan);
  EXPECT_EQ(cut.error().place, "byte 16");
  EXPECT_EQ(parse_text(point + as_bytes({1e9F, 0.0F, 0.0F, 0.0F}), "0.bin", kKitti).error().code,
            kUnsupportedFormat);
}

}  // namespace
}  // namespace sightline
