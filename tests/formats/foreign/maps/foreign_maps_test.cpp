#include "formats/foreign/maps/foreign_maps.h"

#include <cmath>

#include "formats/base/random.h"
#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/maps/coordinate_spacing.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

class PointMapTest : public testing::Test {
 protected:
  void write_square(const std::string& name, float x_m, float y_m) {
    const PointXyzi points[] = {{x_m, y_m, 1.0F, 0.0F}, {x_m + 5.0F, y_m, 2.0F, 0.0F}};
    ASSERT_TRUE(write_pcd_binary(folder_ / name, points).has_value());
  }
  ErrorCode refusal(const std::string& name) { return code_of(open_point_map(folder_ / name, 1)); }
  ScratchFolder folder_;
};

TEST_F(PointMapTest, AutowaresSquaresAreThoseOfItsMetadata) {
  write_square("map/pointcloud_map.pcd/0_0.pcd", 0.0F, 0.0F);
  write_square("map/pointcloud_map.pcd/20_0.pcd", 20.0F, 0.0F);
  write_square("map/pointcloud_map.pcd/old.pcd", 900.0F, 0.0F);
  folder_.write("map/pointcloud_map_metadata.yaml",
                "x_resolution: 20.0\ny_resolution: 20.0\n20_0.pcd: [20, 0]\n0_0.pcd: [0, 0]\n");
  const PointMap map = value_of(open_point_map(folder_ / "map", 2));
  EXPECT_EQ(map.name, "map");
  ASSERT_EQ(map.files.size(), 2U) << "a file that the metadata do not name is none of the map";
  EXPECT_EQ(map.files[0].name, "0_0.pcd");
  EXPECT_EQ(map.files[1].box_m.max().x(), 25.0);
  const PointMap squares = value_of(open_point_map(folder_ / "map/pointcloud_map.pcd", 1));
  EXPECT_EQ(squares.digest, map.digest);
  EXPECT_EQ(squares.name, "map");

  const std::shared_ptr<const ScanStore> store = point_map_store(map);
  EXPECT_FALSE(store->has_origins()) << "from where a map was seen is unknown";
  EXPECT_EQ(value_of(store->read(1)).points_m[0], Eigen::Vector3d(20.0, 0.0, 1.0));
}

TEST_F(PointMapTest, OneFileIsAMapToo) {
  write_square("city.pcd", 100.0F, 50.0F);
  const PointMap map = value_of(open_point_map(folder_ / "city.pcd", 1));
  EXPECT_EQ(map.name, "city.pcd");
  EXPECT_EQ(map.files[0].point_count, 2U);
}

TEST_F(PointMapTest, TheDigestNamesWhatTheFilesHold) {
  write_square("a/1.pcd", 0.0F, 0.0F);
  write_square("b/1.pcd", 0.0F, 0.0F);
  write_square("c/1.pcd", 1.0F, 0.0F);
  const auto digest = [&](const char* name) { return open_point_map(folder_ / name, 1)->digest; };
  EXPECT_EQ(digest("a"), digest("b"));
  EXPECT_NE(digest("a"), digest("c"));
}

TEST_F(PointMapTest, RefusesWhatIsNoMap) {
  EXPECT_EQ(refusal("nowhere.pcd"), ErrorCode::kFileNotFound);
  folder_.write("scan.bin", std::string(160, 'x'));
  EXPECT_EQ(refusal("scan.bin"), ErrorCode::kUnsupportedFormat);
  write_square("hole/pointcloud_map.pcd/0_0.pcd", 0.0F, 0.0F);
  folder_.write("hole/pointcloud_map_metadata.yaml", "0_0.pcd: [0, 0]\n20_0.pcd: [20, 0]\n");
  EXPECT_EQ(refusal("hole"), ErrorCode::kFileNotFound);
  folder_.write("bare/pointcloud_map_metadata.yaml", "x_resolution: 20.0\n");
  EXPECT_EQ(refusal("bare"), ErrorCode::kMalformedText);
}

TEST_F(PointMapTest, RefusesDegrees) {
  const PointXyzi points[] = {{8.3901F, 48.9801F, 110.0F, 0.0F}, {8.3911F, 48.9812F, 140.0F, 0.0F}};
  ASSERT_TRUE(write_pcd_binary(folder_ / "degrees.pcd", points).has_value());
  const Error error = failure_of(open_point_map(folder_ / "degrees.pcd", 1));
  EXPECT_EQ(error.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(error.message, HasSubstr("degrees"));
}

// 40 000 points at random in 80 m by 80 m of UTM, in numbers of some kind.
template <class Round>
std::vector<Eigen::Vector3d> in_utm(Round round) {
  Random random(5);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 40'000; ++i) {
    points_m.emplace_back(round(456'125.0 + random.uniform(0, 80)),
                          round(5'427'629.0 + random.uniform(0, 80)), random.uniform(0, 9));
  }
  return points_m;
}

TEST(CoordinateSpacing, IsThatOfTheNumbersOfAFile) {
  const auto spacing_m = [](const auto& round) {
    return coordinate_spacing(in_utm(round)).spacing_m;
  };
  EXPECT_LT(spacing_m([](double v) { return v; }), 1e-3);
  EXPECT_EQ(spacing_m([](double v) { return static_cast<double>(static_cast<float>(v)); }), 0.5);
  EXPECT_EQ(spacing_m([](double v) { return 10.0 * std::round(0.1 * v); }), 10.0) << "six digits";
  EXPECT_NEAR(spacing_m([](double v) { return 0.01 * std::round(100.0 * v); }), 0.01, 1e-6);
  std::vector<Eigen::Vector3d> near_m = in_utm([](double v) { return 0.5 * std::round(2.0 * v); });
  for (Eigen::Vector3d& point_m : near_m) point_m -= Eigen::Vector3d(456'125.0, 5'427'629.0, 0.0);
  EXPECT_EQ(coordinate_spacing(near_m).spacing_m, 0.0) << "voxels near the origin";
}

TEST_F(PointMapTest, RefusesUtmInFloat32AndWarnsWhereTheStepIsSmall) {
  const auto write = [&](double north_m) {
    std::vector<PointXyzi> points;
    for (const Eigen::Vector3d& point_m : in_utm([](double v) { return v; })) {
      points.push_back({static_cast<float>(point_m.x()),
                        static_cast<float>(point_m.y() - 5'427'629.0 + north_m),
                        static_cast<float>(point_m.z()), 0.0F});
    }
    ASSERT_TRUE(write_pcd_binary(folder_ / "utm.pcd", points, IfExists::kReplace).has_value());
  };
  write(5'427'629.0);
  const Error error = failure_of(open_point_map(folder_ / "utm.pcd", 1));
  EXPECT_EQ(error.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(error.message, HasSubstr("steps of 0.5 m"));
  EXPECT_THAT(error.message, HasSubstr("64 bits"));
  write(150'000.0);
  const PointMap map = value_of(open_point_map(folder_ / "utm.pcd", 1));
  ASSERT_EQ(map.warnings.size(), 1U);
  EXPECT_THAT(map.warnings[0], HasSubstr("steps of 0.03125 m"));
}

TEST_F(PointMapTest, RefusesAPieceThatChangedMeanwhile) {
  write_square("city.pcd", 100.0F, 50.0F);
  const PointMap map = value_of(open_point_map(folder_ / "city.pcd", 1));
  const PointXyzi other[] = {{1.0F, 2.0F, 3.0F, 0.0F}, {9.0F, 2.0F, 3.0F, 0.0F}};
  ASSERT_TRUE(write_pcd_binary(folder_ / "city.pcd", other, IfExists::kReplace).has_value());
  EXPECT_EQ(point_map_store(map)->read(0).error().code, ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
