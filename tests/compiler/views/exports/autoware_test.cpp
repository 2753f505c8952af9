#include "compiler/views/exports/autoware.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <yaml-cpp/yaml.h>

#include <set>

#include "formats/base/random.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

const MapFrame kFrame{{457344.0, 5428224.0, 64.0}};

std::vector<Eigen::Vector3d> random_points(std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 3000; ++i) {
    points_m.emplace_back(random.uniform(-90.0, 90.0), random.uniform(-50.0, 130.0),
                          random.uniform(0.0, 10.0));
  }
  points_m.emplace_back(20.0, -20.0, 0.0);  // on the lines between squares
  points_m.emplace_back(std::nextafter(20.0, 0.0), -1e-12, 0.0);
  return points_m;
}

// The loader's rules: squares of one size, cut along the axes, that do not overlap; metadata that
// names each file's lower corner, a whole multiple of the size.
TEST(AutowareMap, KeepsTheRulesOfTheLoaderAsPclAndYamlRead) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const std::vector<Eigen::Vector3d> points_m = random_points(seed);
    const AutowareMap map = value_of(autoware_map(points_m, kFrame, *parse_world("local")));
    YAML::Node metadata = YAML::Load(map.metadata_yaml);
    EXPECT_EQ(metadata["x_resolution"].as<double>(), 20.0);
    EXPECT_EQ(metadata["y_resolution"].as<double>(), 20.0);
    EXPECT_EQ(metadata.size(), map.squares.size() + 2);
    std::set<std::pair<double, double>> corners;
    std::multiset<std::tuple<float, float, float>> read;
    for (const AutowareSquare& square : map.squares) {
      const std::filesystem::path file = scratch_folder() / square.file;
      ASSERT_TRUE(write_pcd_binary(file, square.points, IfExists::kReplace));
      pcl::PointCloud<pcl::PointXYZI> cloud;
      ASSERT_EQ(pcl::io::loadPCDFile(file.string(), cloud), 0);
      EXPECT_FALSE(cloud.empty());
      ASSERT_TRUE(metadata[square.file]) << square.file;
      const auto x_m = metadata[square.file][0].as<double>();
      const auto y_m = metadata[square.file][1].as<double>();
      EXPECT_EQ(std::fmod(x_m, 20.0), 0.0);
      EXPECT_EQ(std::fmod(y_m, 20.0), 0.0);
      EXPECT_TRUE(corners.emplace(x_m, y_m).second) << "two files for one square";
      for (const pcl::PointXYZI& p : cloud) {
        EXPECT_TRUE(p.x >= x_m && p.x < x_m + 20.0 && p.y >= y_m && p.y < y_m + 20.0)
            << p.x << " " << p.y << " in " << square.file;
        read.emplace(p.x, p.y, p.z);
      }
    }
    std::multiset<std::tuple<float, float, float>> given;
    for (const Eigen::Vector3d& p_m : points_m) {
      // Of the world, less whole 100 km.
      given.emplace(static_cast<float>(p_m.x() + 57'344.0), static_cast<float>(p_m.y() + 28'224.0),
                    static_cast<float>(p_m.z() + 64.0));
    }
    EXPECT_EQ(read, given);
  }
}

TEST(AutowareMap, SaysWhereItLies) {
  const std::vector<Eigen::Vector3d> points_m = {{1.0, 2.0, 3.0}};
  const auto projector = [&](const char* world, const MapFrame& frame) {
    const Result<AutowareMap> map = autoware_map(points_m, frame, *parse_world(world));
    EXPECT_TRUE(map) << world;
    return YAML::Load(map->projector_yaml);
  };
  EXPECT_EQ(projector("local", kFrame)["projector_type"].as<std::string>(), "Local");
  // The first scan lies just behind a square's edge, the frame's origin just before it.
  const MapFrame at_edge{{399'936.0, 5'428'224.0, 0.0}};
  for (const auto& [world, frame, square] :
       {std::tuple{"utm:32N", kFrame, "32UMV"}, std::tuple{"utm:32N", at_edge, "32ULV"},
        std::tuple{"mgrs:32UMV", MapFrame{{57'344.0, 28'224.0, 64.0}}, "32UMV"},
        std::tuple{"mgrs:32UMV", MapFrame{{-64.0, 28'224.0, 64.0}}, "32UMV"}}) {
    const YAML::Node yaml = projector(world, frame);
    EXPECT_EQ(yaml["projector_type"].as<std::string>(), "MGRS");
    EXPECT_EQ(yaml["vertical_datum"].as<std::string>(), "WGS84");
    EXPECT_EQ(yaml["mgrs_grid"].as<std::string>(), square) << world;
  }
  const YAML::Node enu = projector("enu:48.5,8.25,100", MapFrame{{-64.0, 128.0, 0.0}});
  EXPECT_EQ(enu["projector_type"].as<std::string>(), "LocalCartesian");
  EXPECT_EQ(enu["map_origin"]["latitude"].as<double>(), 48.5);
  EXPECT_EQ(autoware_map(points_m, kFrame, *parse_world("enu:48.5,8.25,100")).error().code,
            ErrorCode::kBadArgument)
      << "457 km from the origin of its world";
  EXPECT_EQ(autoware_map({}, kFrame, World{}).error().code, ErrorCode::kEmptyMap);
}

}  // namespace
}  // namespace sightline
