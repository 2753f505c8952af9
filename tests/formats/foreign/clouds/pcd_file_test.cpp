#include <pcl/console/print.h>
#include <pcl/io/lzf.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <limits>

#include "formats/base/random.h"
#include "formats/foreign/clouds/pcd_unpack.h"
#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

using enum ErrorCode;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string pcd(std::string_view fields, std::string_view sizes, std::string_view types, int points,
                std::string_view encoding, std::string_view data) {
  std::string text = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n";
  text.append("FIELDS ").append(fields).append("\nSIZE ").append(sizes);
  text.append("\nTYPE ").append(types).append("\nWIDTH ").append(std::to_string(points));
  text.append("\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ").append(std::to_string(points));
  return text.append("\nDATA ").append(encoding).append("\n").append(data);
}

std::string ascii_pcd(int points, std::string_view data) {
  return pcd("x y z", "4 4 4", "F F F", points, "ascii", data);
}

ErrorCode code_of(const std::string& text) { return code_of(parse_text(text, "a.pcd")); }

struct Layout {
  std::vector<std::pair<std::string, std::uint8_t>> fields;  // name, PCL datatype; any order
};

std::uint32_t size_of(std::uint8_t datatype) {
  return static_cast<std::uint32_t>(pcl::getFieldSize(datatype));
}

Layout random_layout(Random& random) {
  using pcl::PCLPointField;
  const bool is_double = random.below(2) == 1;
  const std::uint8_t position = is_double ? PCLPointField::FLOAT64 : PCLPointField::FLOAT32;
  Layout layout{{{"x", position}, {"y", position}, {"z", position}}};
  const std::uint8_t others[] = {PCLPointField::UINT8, PCLPointField::INT16, PCLPointField::UINT32,
                                 PCLPointField::FLOAT32, PCLPointField::FLOAT64};
  if (random.below(2) == 1) layout.fields.emplace_back("intensity", others[random.below(5)]);
  if (random.below(2) == 1) layout.fields.emplace_back("ring", others[random.below(3)]);
  if (random.below(2) == 1) layout.fields.emplace_back("timestamp", PCLPointField::FLOAT64);
  for (std::size_t i = layout.fields.size() - 1; i > 0; --i) {
    std::swap(layout.fields[i], layout.fields[random.below(i + 1)]);
  }
  return layout;
}

void put(std::uint8_t* bytes, std::uint8_t datatype, double value) {
  const auto store = [&](auto typed) { std::memcpy(bytes, &typed, sizeof typed); };
  switch (datatype) {
    case pcl::PCLPointField::UINT8:
      return store(static_cast<std::uint8_t>(value));
    case pcl::PCLPointField::INT16:
      return store(static_cast<std::int16_t>(value));
    case pcl::PCLPointField::UINT32:
      return store(static_cast<std::uint32_t>(value));
    case pcl::PCLPointField::FLOAT32:
      return store(static_cast<float>(value));
    default:
      return store(value);
  }
}

struct Expected {
  pcl::PCLPointCloud2 cloud;
  std::vector<Eigen::Vector3d> points_m;
  std::vector<float> intensity;
  std::uint64_t nonfinite_count = 0;
  std::uint64_t zero_count = 0;
};

Eigen::Vector3d random_point(Random& random, double scale_m) {
  const std::uint64_t kind = random.below(10);
  if (kind == 0) return Eigen::Vector3d::Zero();
  Eigen::Vector3d point_m(random.uniform(-scale_m, scale_m), random.uniform(-scale_m, scale_m),
                          random.uniform(-5.0, 20.0));
  if (kind == 1) point_m[static_cast<Eigen::Index>(random.below(3))] = kNan;
  return point_m;
}

void describe(const Layout& layout, std::uint32_t count, pcl::PCLPointCloud2& cloud) {
  std::uint32_t offset = 0;
  for (const auto& [name, datatype] : layout.fields) {
    pcl::PCLPointField& field = cloud.fields.emplace_back();
    field.name = name;
    field.datatype = datatype;
    field.count = 1;
    field.offset = offset;
    offset += size_of(datatype);
  }
  cloud.width = count;
  cloud.height = 1;
  cloud.point_step = offset;
  cloud.row_step = offset * count;
  cloud.data.assign(static_cast<std::size_t>(offset) * count, 0);
}

Expected random_cloud(Random& random) {
  Expected expected;
  const Layout layout = random_layout(random);
  const auto count = static_cast<std::uint32_t>(2 + random.below(60));
  describe(layout, count, expected.cloud);
  // The last point is a return, so that the cloud is never refused as a whole.
  for (std::uint32_t i = 0; i < count; ++i) {
    Eigen::Vector3d point_m = random_point(random, 4e6);
    if (i + 1 == count) point_m = Eigen::Vector3d(1.0, 2.0, 3.0);
    float intensity = 0.0F;
    for (const pcl::PCLPointField& field : expected.cloud.fields) {
      std::uint8_t* bytes =
          expected.cloud.data.data() + i * expected.cloud.point_step + field.offset;
      double value = std::floor(random.uniform(0.0, 120.0));
      if (field.name == "intensity") intensity = static_cast<float>(value);
      const std::size_t axis = std::string("xyz").find(field.name);
      if (field.name.size() == 1 && axis != std::string::npos) {
        double& coordinate = point_m[static_cast<Eigen::Index>(axis)];
        if (field.datatype == pcl::PCLPointField::FLOAT32) {
          coordinate = static_cast<double>(static_cast<float>(coordinate));
        }
        value = coordinate;
      }
      put(bytes, field.datatype, value);
    }
    if (!point_m.allFinite()) {
      ++expected.nonfinite_count;
    } else if (point_m.isZero(0.0)) {
      ++expected.zero_count;
    } else {
      expected.points_m.push_back(point_m);
      expected.intensity.push_back(intensity);
    }
  }
  return expected;
}

void write_with_pcl(const pcl::PCLPointCloud2& cloud, int encoding,
                    const std::filesystem::path& path) {
  pcl::PCDWriter writer;
  const Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  const Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
  int status = -1;
  if (encoding == 0) status = writer.writeASCII(path.string(), cloud, origin, orientation, 17);
  if (encoding == 1) status = writer.writeBinary(path.string(), cloud, origin, orientation);
  if (encoding == 2) {
    status = writer.writeBinaryCompressed(path.string(), cloud, origin, orientation);
  }
  ASSERT_EQ(status, 0);
}

TEST(PcdFile, ReadsWhatPclWritesInEveryEncodingFieldOrderAndType) {
  const ScratchFolder folder;
  Random random(1);
  for (int round = 0; round < 60; ++round) {
    const Expected expected = random_cloud(random);
    const std::filesystem::path path = folder / "cloud.pcd";
    write_with_pcl(expected.cloud, round % 3, path);
    const PointCloudFile cloud = value_of(read_point_cloud(path));
    EXPECT_EQ(cloud.points_m, expected.points_m) << "round " << round;
    EXPECT_EQ(cloud.intensity, expected.intensity) << "round " << round;
    EXPECT_EQ(cloud.nonfinite_count, expected.nonfinite_count);
    EXPECT_EQ(cloud.zero_count, expected.zero_count);
  }
}

TEST(PcdFile, KeepsEveryReturnOfALargeCloudAndNothingElse) {
  const ScratchFolder folder;
  Random random(3);
  pcl::PointCloud<pcl::PointXYZI> cloud;
  std::vector<Eigen::Vector3d> expected_m;
  std::vector<float> intensity;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3f drawn(static_cast<float>(random.uniform(-80.0, 80.0)),
                                random.below(9) == 0 ? 0.0F : 1.5F, 0.25F);
    Eigen::Vector3f point = drawn;
    const bool is_bad_stretch = i / 700 % 2 == 1;
    if (is_bad_stretch && random.below(5) == 0) point.setZero();
    if (is_bad_stretch && random.below(7) == 0) point[2] = std::numeric_limits<float>::infinity();
    if (random.below(50) == 0) point[0] = -0.0F;
    cloud.emplace_back(point.x(), point.y(), point.z(), static_cast<float>(i));
    if (!point.allFinite() || point.isZero(0.0F)) continue;
    expected_m.emplace_back(point.cast<double>());
    intensity.push_back(static_cast<float>(i));
  }
  pcl::io::savePCDFileBinary((folder / "0.pcd").string(), cloud);
  pcl::io::savePCDFileBinaryCompressed((folder / "1.pcd").string(), cloud);
  for (const char* name : {"0.pcd", "1.pcd"}) {
    const PointCloudFile ours = value_of(read_point_cloud(folder / name));
    EXPECT_EQ(ours.points_m, expected_m);
    EXPECT_EQ(ours.intensity, intensity);
    EXPECT_EQ(ours.zero_count + ours.nonfinite_count + expected_m.size(), cloud.size());
  }
}

std::vector<std::uint8_t> random_text(Random& random, std::size_t size) {
  std::vector<std::uint8_t> bytes;
  while (bytes.size() < size) {
    const std::uint64_t kind = random.below(3);
    const std::size_t length = 1 + random.below(600);
    for (std::size_t i = 0; i < length; ++i) {
      const std::size_t back = 1 + (kind == 0 ? 0 : 37);
      const bool can_repeat = kind != 2 && bytes.size() >= back;
      bytes.push_back(can_repeat ? bytes[bytes.size() - back]
                                 : static_cast<std::uint8_t>(random.below(256)));
    }
  }
  return bytes;
}

TEST(Lzf, UnpacksWhatPclPacks) {
  Random random(4);
  for (int round = 0; round < 100; ++round) {
    const std::vector<std::uint8_t> text = random_text(random, 1 + random.below(20000));
    std::vector<std::uint8_t> packed(2 * text.size() + 64);
    packed.resize(pcl::lzfCompress(text.data(), static_cast<unsigned>(text.size()), packed.data(),
                                   static_cast<unsigned>(packed.size())));
    if (packed.empty()) continue;  // it does not pack what would grow
    std::vector<std::uint8_t> unpacked(text.size());
    ASSERT_TRUE(unpack_lzf(packed, unpacked));
    EXPECT_EQ(unpacked, text);
    std::vector<std::uint8_t> longer(text.size() + 1);
    EXPECT_FALSE(unpack_lzf(packed, longer));
    EXPECT_FALSE(unpack_lzf(packed, std::span(unpacked).first(text.size() - 1)));
    EXPECT_FALSE(unpack_lzf(std::span(packed).first(packed.size() - 1), unpacked));
  }
}

TEST(Lzf, RefusesToReachBehindTheBeginning) {
  // One literal, then three bytes from two back.
  const std::vector<std::uint8_t> stream = {0, 'a', 1 << 5, 1};
  std::vector<std::uint8_t> unpacked(4);
  EXPECT_FALSE(unpack_lzf(stream, unpacked));
  const std::vector<std::uint8_t> sound = {0, 'a', 1 << 5, 0};
  ASSERT_TRUE(unpack_lzf(sound, unpacked));
  EXPECT_EQ(unpacked, std::vector<std::uint8_t>(4, 'a'));
}

TEST(PcdFile, OurWriterIsReadByPclAndByUs) {
  const ScratchFolder folder;
  const std::vector<PointXyzi> points = {{1.5F, -2.25F, 3.0F, 0.5F}, {1e-3F, 4e5F, -7.0F, 255.0F}};
  ASSERT_TRUE(write_pcd_binary(folder / "ours.pcd", points).has_value());
  pcl::PointCloud<pcl::PointXYZI> theirs;
  ASSERT_EQ(pcl::io::loadPCDFile((folder / "ours.pcd").string(), theirs), 0);
  const PointCloudFile ours = value_of(read_point_cloud(folder / "ours.pcd"));
  ASSERT_EQ(theirs.size(), points.size());
  ASSERT_EQ(ours.points_m.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(theirs[i].x, points[i].x_m);
    EXPECT_EQ(theirs[i].y, points[i].y_m);
    EXPECT_EQ(theirs[i].z, points[i].z_m);
    EXPECT_EQ(theirs[i].intensity, points[i].intensity);
    EXPECT_EQ(ours.points_m[i], Eigen::Vector3d(points[i].x_m, points[i].y_m, points[i].z_m));
    EXPECT_EQ(ours.intensity[i], points[i].intensity);
  }
}

TEST(PcdFile, OurWriterLeavesAnExistingFileAloneUnlessTold) {
  const ScratchFolder folder;
  const std::vector<PointXyzi> points = {{1.0F, 2.0F, 3.0F, 4.0F}};
  folder.write("there.pcd", "precious");
  EXPECT_EQ(code_of(write_pcd_binary(folder / "there.pcd", points)), kOutputExists);
  EXPECT_EQ(*read_text_file(folder / "there.pcd"), "precious");
  EXPECT_TRUE(write_pcd_binary(folder / "there.pcd", points, IfExists::kReplace).has_value());
  EXPECT_TRUE(read_point_cloud(folder / "there.pcd").has_value());
}

TEST(PcdFile, TextKeepsTheMillimetresOfUtmThoughTheHeaderSaysFloat) {
  const PointCloudFile cloud =
      value_of(parse_text(ascii_pcd(1, "588348.947978 4141240.223859 -30.094324\n"), "utm.pcd"));
  EXPECT_EQ(cloud.points_m.at(0), Eigen::Vector3d(588348.947978, 4141240.223859, -30.094324));
}

TEST(PcdFile, ReadsOldAndUnusualHeaders) {
  const std::string old_version =
      "# .PCD v.5\nVERSION .5\nCOLUMNS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 "
      "3\n";
  const std::string other_order = "DATA_\n" + old_version;  // refused below
  EXPECT_TRUE(parse_text(old_version, "a.pcd").has_value());
  EXPECT_EQ(code_of(other_order), kMalformedHeader);
  const PointCloudFile windows =
      value_of(parse_text("VERSION 0.7\r\nFIELDS x y z\r\nSIZE 4 4 4\r\nTYPE F F F\r\nWIDTH 1\r\n"
                          "HEIGHT 1\r\nPOINTS 1\r\nDATA ascii\r\n1 2 3\r\n",
                          "a.pcd"));
  EXPECT_EQ(windows.points_m.at(0), Eigen::Vector3d(1, 2, 3));
}

TEST(PcdFile, SkipsPaddingFieldsInEveryEncoding) {
  std::string header =
      "VERSION 0.7\nFIELDS x _ y z _\nSIZE 4 1 4 4 1\nTYPE F U F F U\nCOUNT 1 4 1 1 3\nWIDTH 2\n"
      "HEIGHT 1\nPOINTS 2\nDATA binary\n";
  const std::string first = as_bytes({1.0F}) + "pad." + as_bytes({2.0F, 3.0F}) + "...";
  const std::string second = as_bytes({4.0F}) + "pad." + as_bytes({5.0F, 6.0F}) + "...";
  const PointCloudFile cloud = value_of(parse_text(header + first + second, "a.pcd"));
  EXPECT_EQ(cloud.points_m.at(1), Eigen::Vector3d(4, 5, 6));
}

TEST(PcdFile, UnpacksCompressedColumnsWithAndWithoutTheirPadding) {
  const std::string header =
      "VERSION 0.7\nFIELDS x _ y z\nSIZE 4 1 4 4\nTYPE F U F F\nCOUNT 1 4 1 1\nWIDTH 2\n"
      "HEIGHT 1\nPOINTS 2\nDATA binary_compressed\n";
  // An LZF stream may be literals only: a length less one, then as many bytes.
  const auto body = [](const std::string& columns) {
    std::string stream;
    for (std::size_t at = 0; at < columns.size(); at += 32) {
      const std::string part = columns.substr(at, 32);
      stream += static_cast<char>(part.size() - 1);
      stream += part;
    }
    return as_bytes({static_cast<std::uint32_t>(stream.size()),
                     static_cast<std::uint32_t>(columns.size())}) +
           stream;
  };
  const std::string x = as_bytes({1.0F, 4.0F});
  const std::string yz = as_bytes({2.0F, 5.0F, 3.0F, 6.0F});
  for (const std::string& columns : {x + yz, x + "pad.pad." + yz}) {
    const PointCloudFile cloud = value_of(parse_text(header + body(columns), "a.pcd"));
    EXPECT_EQ(cloud.points_m.at(0), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(cloud.points_m.at(1), Eigen::Vector3d(4, 5, 6));
  }
}

TEST(PcdFile, RefusesHeadersThatLie) {
  const std::string point = as_bytes({1.0F, 2.0F, 3.0F});
  const auto binary = [&](int points) {
    return pcd("x y z", "4 4 4", "F F F", points, "binary", point + point);
  };
  EXPECT_TRUE(parse_text(binary(2), "a.pcd").has_value());
  EXPECT_EQ(code_of(binary(3)), kTruncatedScan);
  EXPECT_EQ(code_of(binary(1)), kMalformedHeader);
  EXPECT_EQ(code_of(binary(0)), kEmptyScan);
  EXPECT_EQ(code_of(binary(2147483647)), kTruncatedScan);
  EXPECT_EQ(code_of(ascii_pcd(2, "1 2 3\n")), kTruncatedScan);
  EXPECT_EQ(code_of(ascii_pcd(1, "1 2 3\n4 5 6\n")), kMalformedHeader);
  EXPECT_EQ(code_of(ascii_pcd(1, "1 2\n")), kTruncatedScan);
  EXPECT_EQ(code_of(ascii_pcd(1, "1 2 3 4\n")), kTruncatedScan);
  EXPECT_EQ(code_of(ascii_pcd(1, "1 2 three\n")), kMalformedText);
  std::string product = binary(2);
  product.replace(product.find("HEIGHT 1"), 8, "HEIGHT 3");
  EXPECT_EQ(code_of(product), kMalformedHeader);
  // A stream of 16 bytes cannot hold 4 GB.
  const std::string bomb = as_bytes<std::uint32_t>({16, 2147483640}) + std::string(16, '\x1f');
  EXPECT_EQ(code_of(pcd("x y z", "4 4 4", "F F F", 178956970, "binary_compressed", bomb)),
            kMalformedHeader);
}

TEST(PcdFile, RefusesHeadersThatMakeNoSense) {
  EXPECT_EQ(code_of(pcd("x y z", "4 4", "F F F", 1, "ascii", "1 2 3\n")), kMalformedHeader);
  EXPECT_EQ(code_of(pcd("x y z", "4 4 3", "F F F", 1, "ascii", "1 2 3\n")), kMalformedHeader);
  EXPECT_EQ(code_of(pcd("x y z", "4 4 4", "F F Q", 1, "ascii", "1 2 3\n")), kMalformedHeader);
  EXPECT_EQ(code_of(pcd("x y z", "4 4 4", "F F F", 1, "base64", "1 2 3\n")), kMalformedHeader);
  EXPECT_EQ(code_of(pcd("x y i", "4 4 4", "F F F", 1, "ascii", "1 2 3\n")), kMissingField);
  EXPECT_EQ(code_of("VERSION 0.8\nDATA ascii\n"), kUnsupportedFormat);
  EXPECT_EQ(code_of("FIELDS x y z\nFIELDS x y z\n"), kMalformedHeader);
  EXPECT_EQ(code_of(pcd("x y z x", "4 4 4 4", "F F F F", 1, "ascii", "1 2 3 4\n")),
            kMalformedHeader);
  EXPECT_EQ(code_of("hello\n"), kMalformedHeader);
  EXPECT_EQ(code_of("FIELDS\nDATA ascii\n"), kMalformedHeader);
}

TEST(PcdFile, SaysWhereAFileIsCut) {
  const std::string whole =
      pcd("x y z", "4 4 4", "F F F", 2, "binary", as_bytes({1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F}));
  const Error cut = failure_of(parse_text(whole.substr(0, whole.size() - 3), "drive/7.pcd"));
  EXPECT_EQ(cut.file, "drive/7.pcd");
  EXPECT_EQ(cut.place, "byte " + std::to_string(whole.size() - 3));
  EXPECT_EQ(failure_of(parse_text(ascii_pcd(3, "1 2 3\n4 5\n"), "a.pcd")).place, "line 12");
}

TEST(PcdFile, DropsAndCountsWhatIsNoReturn) {
  const PointCloudFile cloud =
      value_of(parse_text(ascii_pcd(5, "1 2 3\nnan 2 3\n0 0 0\n1 -inf 3\n0 0 1\n"), "a.pcd"));
  EXPECT_EQ(cloud.points_m,
            (std::vector<Eigen::Vector3d>{Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 0, 1)}));
  EXPECT_EQ(cloud.nonfinite_count, 2U);
  EXPECT_EQ(cloud.zero_count, 1U);
}

TEST(PcdFile, RefusesAScanWithoutAnyReturn) {
  EXPECT_EQ(code_of(ascii_pcd(2, "nan nan nan\n0 0 0\n")), kNoFinitePoints);
}

class DamagedPcd : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    Random random(7);
    Expected expected = random_cloud(random);
    while (expected.points_m.size() < 4 || expected.points_m.size() > 10) {
      expected = random_cloud(random);
    }
    const ScratchFolder folder;
    write_with_pcl(expected.cloud, GetParam(), folder / "a.pcd");
    const std::string text = value_of(read_text_file(folder / "a.pcd"));
    whole_ = without_padding(text, expected.cloud.data.size());
  }
  // PCL fills the last page of a file with zeros, which may be lost without harm.
  static std::string without_padding(const std::string& text, std::size_t data_size) {
    const std::size_t data = text.find('\n', text.find("\nDATA ") + 1) + 1;
    if (GetParam() == 0) return text;
    if (GetParam() == 1) return text.substr(0, data + data_size);
    std::uint32_t packed_size = 0;
    std::memcpy(&packed_size, text.data() + data, sizeof packed_size);
    return text.substr(0, data + 8 + packed_size);
  }
  std::string whole_;
};

TEST_P(DamagedPcd, IsRefusedOrFlaggedWhereverItIsCut) {
  expect_every_cut_is_noticed(whole_, "a.pcd");
}

TEST_P(DamagedPcd, NeverCrashesWhicheverByteIsDamaged) {
  expect_no_damage_crashes(whole_, "a.pcd");
}

INSTANTIATE_TEST_SUITE_P(Encodings, DamagedPcd, testing::Values(0, 1, 2));

}  // namespace
}  // namespace sightline
