#include <array>
#include <limits>

#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

struct LasPoint {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  std::uint16_t intensity = 0;
  double time_s = 0.0;
  std::uint8_t flags = 0;  // the sixteenth byte: class and flags, or flags alone
};

// Lengths and places of the GPS time as the tables of the ASPRS specification list them.
struct Format {
  int id;
  int minor;  // the version that brought it
  std::uint16_t length;
  std::size_t time_at;  // 0: none
};
const std::vector<Format> kFormats = {
    {0, 0, 20, 0},  {1, 0, 28, 20}, {2, 2, 26, 0},  {3, 2, 34, 20}, {4, 3, 57, 20}, {5, 3, 63, 20},
    {6, 4, 30, 22}, {7, 4, 36, 22}, {8, 4, 38, 22}, {9, 4, 59, 22}, {10, 4, 67, 22}};

// A LAS file as the specification draws it. `extra` bytes stand behind each point, and a variable
// length record between header and points.
std::string las(const Format& format, int minor, const std::vector<LasPoint>& points,
                std::uint16_t extra = 0) {
  const std::size_t header_size = minor == 4 ? 375 : minor == 3 ? 235 : 227;
  const std::size_t data_at = header_size + 54 + 10;
  std::string bytes(data_at, '\0');
  bytes.replace(0, 4, "LASF");
  put<std::uint8_t>(bytes, 24, 1);
  put(bytes, 25, static_cast<std::uint8_t>(minor));
  put(bytes, 94, static_cast<std::uint16_t>(header_size));
  put(bytes, 96, static_cast<std::uint32_t>(data_at));
  put<std::uint32_t>(bytes, 100, 1);
  put(bytes, 104, static_cast<std::uint8_t>(format.id));
  put(bytes, 105, static_cast<std::uint16_t>(format.length + extra));
  const auto count = static_cast<std::uint32_t>(points.size());
  if (format.id < 6) put(bytes, 107, count);
  if (minor == 4) put(bytes, 247, std::uint64_t{count});
  const double scale[3] = {0.001, 0.01, 0.5};
  const double offset[3] = {635'000.0, 0.0, -10.0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(bytes, 131 + 8 * axis, scale[axis]);
    put(bytes, 155 + 8 * axis, offset[axis]);
  }
  for (const LasPoint& point : points) {
    const std::size_t at = bytes.size();
    bytes.append(format.length + extra, '\x55');
    put(bytes, at, point.x);
    put(bytes, at + 4, point.y);
    put(bytes, at + 8, point.z);
    put(bytes, at + 12, point.intensity);
    put(bytes, at + 15, point.flags);
    if (format.time_at != 0) put(bytes, at + format.time_at, point.time_s);
  }
  return bytes;
}

const std::vector<LasPoint> kPoints = {{1500, -200, 30, 7, 211'543'210.00},
                                       {-1, 0, 0, 65535, 211'543'210.02},
                                       {2'000'000'000, 1, 2, 0, 211'543'210.10}};

TEST(LasFile, ReadsEveryPointFormatScaledWithIntensityAndTime) {
  for (const Format& format : kFormats) {
    for (int minor = format.minor; minor <= 4; ++minor) {
      const PointCloudFile cloud = value_of(parse_text(las(format, minor, kPoints), "0.las"));
      ASSERT_EQ(cloud.points_m.size(), 3U) << format.id;
      EXPECT_TRUE(cloud.points_m[0].isApprox(Eigen::Vector3d(635'001.5, -2.0, 5.0), 1e-14));
      EXPECT_TRUE(cloud.points_m[2].isApprox(Eigen::Vector3d(2'635'000.0, 0.01, -9.0), 1e-14));
      EXPECT_EQ(cloud.intensity, (std::vector<float>{7.0F, 65535.0F, 0.0F}));
      EXPECT_FALSE(cloud.has_unclear_times);
      const bool has_time = format.time_at != 0;
      ASSERT_EQ(cloud.time_offset_ns.size(), has_time ? 3U : 0U) << format.id;
      if (!has_time) continue;
      EXPECT_NEAR(cloud.time_offset_ns[1], 20'000'000, 100);
      EXPECT_NEAR(cloud.time_offset_ns[2], 100'000'000, 100);
      EXPECT_NEAR(static_cast<double>(*cloud.time_origin_ns), 211'543'210e9, 100.0);
    }
  }
}

TEST(LasFile, SkipsExtraBytesOfAPointAndLeavesOutTimesOfAWholeFlight) {
  std::vector<LasPoint> points = kPoints;
  points[2].time_s += 600.0;
  const PointCloudFile cloud = value_of(parse_text(las(kFormats[3], 2, points, 9), "0.las"));
  EXPECT_EQ(cloud.intensity, (std::vector<float>{7.0F, 65535.0F, 0.0F}));
  EXPECT_TRUE(cloud.time_offset_ns.empty());
  EXPECT_TRUE(cloud.has_unclear_times);
}

TEST(LasFile, NoticesEveryCutAndSurvivesAllDamage) {
  for (const int id : {3, 6}) {
    const std::string whole = las(kFormats[static_cast<std::size_t>(id)], 4, kPoints);
    expect_every_cut_is_noticed(whole, "0.las");
    expect_no_damage_crashes(whole, "0.las");
  }
}

TEST(LasFile, RefusesLazAndWhatContradictsItselfAndSaysWhy) {
  const std::string whole = las(kFormats[3], 2, kPoints);
  const auto refusal = [&](std::size_t at, auto value) {
    std::string bytes = whole;
    put(bytes, at, value);
    return failure_of(parse_text(bytes, "0.las"), at);
  };
  const Error laz = refusal(104, std::uint8_t{0x83});
  EXPECT_EQ(laz.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(laz.message, HasSubstr("laszip -i"));
  EXPECT_EQ(refusal(25, std::uint8_t{5}).code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(refusal(104, std::uint8_t{11}).code, ErrorCode::kMalformedHeader);
  EXPECT_EQ(refusal(105, std::uint16_t{33}).code, ErrorCode::kMalformedHeader);
  EXPECT_EQ(refusal(96, std::uint32_t{226}).code, ErrorCode::kMalformedHeader);
  EXPECT_EQ(refusal(107, std::uint32_t{4}).code, ErrorCode::kTruncatedScan);
  EXPECT_EQ(refusal(107, std::uint32_t{2}).code, ErrorCode::kMalformedHeader);
  EXPECT_EQ(refusal(107, std::uint32_t{0}).code, ErrorCode::kEmptyScan);
  EXPECT_EQ(refusal(131, 0.0).code, ErrorCode::kMalformedHeader);
  EXPECT_EQ(refusal(155, std::numeric_limits<double>::infinity()).code,
            ErrorCode::kMalformedHeader);
}

TEST(LasFile, LeavesOutWithheldPointsAndCountsThem) {
  for (const Format& format : kFormats) {
    std::vector<LasPoint> points = kPoints;
    points[1].flags = format.id < 6 ? 0x82 : 0x04;
    points[2].flags = format.id < 6 ? 0x7f : 0xfb;  // all but that one
    const PointCloudFile cloud = value_of(parse_text(las(format, 4, points), "0.las"));
    EXPECT_EQ(cloud.withheld_count, 1U) << format.id;
    EXPECT_EQ(cloud.intensity, (std::vector<float>{7.0F, 0.0F})) << format.id;
    EXPECT_EQ(cloud.time_offset_ns.size(), format.time_at == 0 ? 0U : 2U) << format.id;
  }
  // LAS 1.0 had no flags beside the class.
  std::vector<LasPoint> points = kPoints;
  for (LasPoint& point : points) point.flags = 0x82;
  EXPECT_EQ(parse_text(las(kFormats[1], 0, points), "0.las")->withheld_count, 0U);
  const Error error = failure_of(parse_text(las(kFormats[1], 2, points), "0.las"));
  EXPECT_EQ(error.code, ErrorCode::kNoFinitePoints);
  EXPECT_THAT(error.message, HasSubstr("3 are withheld"));
}

std::string with_record(std::uint16_t id, const std::string& content, bool is_extended) {
  std::string bytes = las(kFormats[6], 4, kPoints);
  std::string record(is_extended ? 60 : 54, '\0');
  record.replace(2, 15, "LASF_Projection");
  put(record, 18, id);
  if (is_extended) {
    put(record, 20, std::uint64_t{content.size()});
    put(bytes, 235, std::uint64_t{bytes.size()});
    put(bytes, 243, std::uint32_t{1});
    return bytes + record + content;
  }
  put(record, 20, static_cast<std::uint16_t>(content.size()));
  bytes.replace(375, 64, record + content);
  put(bytes, 96, static_cast<std::uint32_t>(375 + record.size() + content.size()));
  return bytes;
}

std::string geo_keys(std::initializer_list<std::array<std::uint16_t, 2>> keys) {
  std::string content = as_bytes<std::uint16_t>({1, 1, 0, static_cast<std::uint16_t>(keys.size())});
  for (const auto& [key, value] : keys) content += as_bytes<std::uint16_t>({key, 0, 1, value});
  return content;
}

struct Reference {
  std::uint16_t id;
  std::string content;
  std::string refusal;  // part of the message; empty: it is read
};

TEST(LasFile, RefusesCoordinatesThatAreNoMetres) {
  const std::string degrees = "GEOGCS[\"WGS 84\",UNIT[\"degree\",0.0174532925199433]]";
  const std::string utm =
      "PROJCS[\"UTM 32N\"," + degrees + ",PARAMETER[\"k\",0.9996],UNIT[\"metre\",1]]";
  const std::string feet = "PROJCS[\"Oregon (ft)\"," + degrees + ",UNIT[\"foot\",0.3048]]";
  const std::string height_ft = "VERT_CS[\"NAVD88\",UNIT[\"US survey foot\",0.304800609601219]]";
  const std::string utm2 =
      "PROJCRS[\"UTM\",BASEGEOGCRS[\"WGS 84\",ANGLEUNIT[\"degree\",0.017]],CS[Cartesian,2],"
      "AXIS[\"east\",east],LENGTHUNIT[\"metre\",1]]";
  const std::vector<Reference> cases = {
      {34735, geo_keys({{1024, 1}, {3072, 32632}, {3076, 9001}, {4099, 9001}}), ""},
      {34735, geo_keys({{1024, 2}, {2048, 4326}, {2054, 9102}}), "degrees"},
      {34735, geo_keys({{1024, 3}}), "Earth's centre"},
      {34735, geo_keys({{1024, 1}, {3076, 9002}}), "EPSG:9002"},
      {34735, geo_keys({{1024, 1}, {3076, 9001}, {4099, 9003}}), "EPSG:9003"},
      {2112, utm, ""},
      {2112, utm2, ""},
      {2112, "COMPD_CS[\"both\"," + utm + ",VERT_CS[\"height\",UNIT[\"metre\",1]]]", ""},
      {2112, degrees, "degrees"},
      {2112, "COMPD_CS[\"both\"," + degrees + ",VERT_CS[\"height\",UNIT[\"metre\",1]]]", "degrees"},
      {2112, "GEOGCRS[\"WGS 84\",CS[ellipsoidal,2]]", "degrees"},
      {2112, "GEOCCS[\"WGS 84\",UNIT[\"metre\",1]]", "geodetic"},
      {2112, feet, "'\"foot\"'"},
      {2112, "COMPD_CS[\"both\"," + utm + "," + height_ft + "]", "survey foot"},
      {2112, "no reference at all", ""},
      {2112, "PROJCS[\"cut", ""}};
  for (const Reference& reference : cases) {
    for (const bool is_extended : {false, true}) {
      const Result<PointCloudFile> cloud =
          parse_text(with_record(reference.id, reference.content, is_extended), "0.las");
      EXPECT_EQ(cloud.has_value(), reference.refusal.empty()) << reference.content;
      if (cloud) continue;
      EXPECT_EQ(cloud.error().code, ErrorCode::kUnsupportedFormat) << to_string(cloud.error());
      EXPECT_THAT(cloud.error().message, HasSubstr(reference.refusal)) << to_string(cloud.error());
      EXPECT_THAT(cloud.error().message, HasSubstr("pdal translate"));
    }
  }
}

TEST(LasFile, RefusesDegreesThatNoRecordSpeaksOf) {
  // 300 points over 200 m of a street in Berlin, in units of 1e-7 degrees.
  std::vector<LasPoint> points;
  for (int i = 0; i < 300; ++i)
    points.push_back({134'050'000 + 100 * i, 525'200'000 + 60 * i, 30 + i});
  std::string bytes = las(kFormats[0], 2, points);
  for (const std::size_t axis : {0U, 1U, 2U}) put(bytes, 155 + 8 * axis, 0.0);
  put(bytes, 131, 1e-7);
  put(bytes, 139, 1e-7);
  const Error error = failure_of(parse_text(bytes, "0.las"));
  EXPECT_EQ(error.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(error.message, HasSubstr("degrees"));
  put(bytes, 131, 1e-4);
  EXPECT_TRUE(parse_text(bytes, "0.las").has_value());
}

}  // namespace
}  // namespace sightline
