#include "formats/foreign/maps/apollo_map.h"

#include <map>

#include "formats/base/random.h"
#include "formats/foreign/maps/apollo_files.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/formats/foreign/maps/apollo_writer.h"

namespace sightline {
namespace {

struct Moments {
  std::uint32_t count = 0;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

Moments moments_of(const std::vector<Eigen::Vector3d>& points_m) {
  Moments moments;
  moments.count = static_cast<std::uint32_t>(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) moments.mean_m += point_m / moments.count;
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3d off_m = point_m - moments.mean_m;
    moments.covariance_m2 += off_m * off_m.transpose() / (moments.count - 1.0);
  }
  return moments;
}

class ApolloMapTest : public testing::Test {
 protected:
  void write(const ApolloTestIndex& index, const std::string& file) {
    std::filesystem::create_directories((folder_ / apollo_path(index)).parent_path());
    folder_.write(apollo_path(index), file);
  }
  void write_points(const std::vector<Eigen::Vector3d>& points_m, double cell_m,
                    std::int32_t zone = 10) {
    constexpr std::uint32_t kNodeCells = 16;
    std::filesystem::remove_all(folder_ / "map");
    folder_.write("config.xml", apollo_config(cell_m, kNodeCells));
    for (const auto& [place, node] : apollo_nodes(points_m, cell_m, kNodeCells)) {
      const ApolloTestIndex index{0, zone, place.first, place.second};
      write(index, apollo_file(index, zlib_packed(apollo_body(node))));
    }
  }
  void expect_error(ErrorCode code, const std::string& part) {
    const Error error = failure_of(open_apollo_map(folder_.path(), 1));
    EXPECT_EQ(error.code, code) << to_string(error);
    EXPECT_THAT(to_string(error), HasSubstr(part));
  }
  ScratchFolder folder_;
};

std::vector<Eigen::Vector3d> random_points(std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 4000; ++i) {
    points_m.emplace_back(588350.0 + random.uniform(-3.0, 3.0),
                          4141246.0 + random.uniform(-3.0, 6.0), random.uniform(-4.0, 4.0));
  }
  return points_m;
}

TEST_F(ApolloMapTest, NdsAreThoseOfThePointsWhereTheyLay) {
  for (const double cell_m : {1.0, 0.5}) {
    const std::vector<Eigen::Vector3d> points_m = random_points(7);
    write_points(points_m, cell_m);
    const ForeignNds map = value_of(open_apollo_map(folder_.path(), 2));
    ASSERT_TRUE(validate(map).has_value());
    EXPECT_EQ(map.world, "utm:10N");
    EXPECT_EQ(map.cell_m, cell_m);
    EXPECT_EQ(map.point_count, points_m.size());
    // Altitudes are cut towards zero: the cells on both sides of it are one.
    std::map<std::tuple<double, double, double>, std::vector<Eigen::Vector3d>> by_cell;
    for (const Eigen::Vector3d& point_m : points_m) {
      by_cell[{std::floor(point_m.x() / cell_m), std::floor(point_m.y() / cell_m),
               std::trunc(point_m.z() / cell_m)}]
          .push_back(point_m);
    }
    std::map<std::tuple<int, int, int>, Moments> expected;
    std::size_t single_count = 0;
    for (const auto& [key, points_of_cell_m] : by_cell) {
      if (points_of_cell_m.size() < 2) {
        ++single_count;
        continue;
      }
      const Moments moments = moments_of(points_of_cell_m);
      const Eigen::Vector3d cell = (moments.mean_m / cell_m).array().floor();
      expected[{static_cast<int>(cell.x()), static_cast<int>(cell.y()),
                static_cast<int>(cell.z())}] = moments;
    }
    EXPECT_EQ(map.single_point_count, single_count);
    ASSERT_EQ(map.nds.size(), expected.size());
    for (const ForeignNd& nd : map.nds) {
      const CellKey& key = nd.key_world;
      const auto found = expected.find({key.x, key.y, key.z});
      ASSERT_NE(found, expected.end());
      EXPECT_EQ(nd.point_count, found->second.count);
      const Eigen::Vector3d mean_m =
          cell_m * Eigen::Vector3d(key.x, key.y, key.z) + nd.mean_in_cell_m;
      EXPECT_LT((mean_m - found->second.mean_m).norm(), 1e-6);
      EXPECT_LT((nd.covariance_m2 - found->second.covariance_m2).norm(), 1e-5);
    }
  }
}

TEST_F(ApolloMapTest, SaysWhatItIs) {
  write_points(random_points(1), 1.0, -33);
  EXPECT_TRUE(is_apollo_map(folder_.path()));
  EXPECT_TRUE(is_apollo_map(folder_ / "config.xml"));
  EXPECT_FALSE(is_apollo_map(folder_ / "map"));
  EXPECT_FALSE(is_apollo_map(folder_ / "missing"));
  const ForeignNds map = value_of(open_apollo_map(folder_.path(), 1));
  EXPECT_EQ(map.world, "utm:33S");
  EXPECT_EQ(map.name, folder_.path().filename().string());
  const auto files = value_of(list_apollo_map(folder_ / "config.xml"));
  EXPECT_GT(files.size(), 2U);
  EXPECT_EQ(files.front().filename(), "config.xml");
  EXPECT_EQ(open_apollo_map(folder_ / "config.xml", 2)->digest, map.digest);
  write_points(random_points(2), 1.0, -33);
  EXPECT_NE(open_apollo_map(folder_.path(), 1)->digest, map.digest);
}

TEST_F(ApolloMapTest, OfSeveralResolutionsTakesTheLargestCellsOfAtMostTwoMetres) {
  std::string config = apollo_config(1.0, 2);
  for (const char* name : {"resolutions", "resolutions_z"}) {
    const std::string opening = std::string("<") + name + ">";
    const std::string one = "<resolution>1</resolution>";
    config.replace(config.find(opening), opening.size() + one.size(),
                   opening + "<resolution>0.5</resolution><resolution>4</resolution>" + one);
  }
  folder_.write("config.xml", config);
  const ApolloTestIndex index{2, 10, 5, 7};
  write(index, apollo_file(index, zlib_packed(apollo_body(small_node()))));
  const ForeignNds map = value_of(open_apollo_map(folder_.path(), 1));
  EXPECT_EQ(map.cell_m, 1.0);
  ASSERT_EQ(map.nds.size(), 1U);
  EXPECT_EQ(map.nds[0].key_world, (CellKey{15, 10, 3}));
  ASSERT_EQ(map.warnings.size(), 1U);
  EXPECT_THAT(map.warnings[0], HasSubstr("3 resolutions; its cells of 1 m"));
}

TEST_F(ApolloMapTest, RefusesWhatIsNoMapOfOnePlane) {
  expect_error(ErrorCode::kFileNotFound, "config.xml");
  folder_.write("config.xml", apollo_config(1.0, 2));
  expect_error(ErrorCode::kEmptyDirectory, "found no node");
  const std::string body = zlib_packed(apollo_body(small_node()));
  const ApolloTestIndex north{0, 10, 1, 1};
  write(north, apollo_file(north, body));
  EXPECT_TRUE(open_apollo_map(folder_.path(), 1).has_value());
  const ApolloTestIndex west{0, 9, 1, 1};
  write(west, apollo_file(west, body));
  expect_error(ErrorCode::kUnsupportedFormat, "two zones");
}

TEST_F(ApolloMapTest, RefusesCellsThatAreNoCubesOfTheWorldsGrid) {
  std::string flat = apollo_config(1.0, 2);
  flat.replace(flat.rfind(">1<"), 3, ">0.5<");
  folder_.write("config.xml", flat);
  expect_error(ErrorCode::kUnsupportedFormat, "cells of 1 m, 0.5 m high");
  std::string shifted = apollo_config(1.0, 2);
  shifted.replace(shifted.find("<min_x>0"), 8, "<min_x>0.25");
  folder_.write("config.xml", shifted);
  expect_error(ErrorCode::kUnsupportedFormat, "does not begin at a multiple of its cell");
}

TEST(ApolloConfig, RefusesWhatNoMapSays) {
  const std::string good = apollo_config(1.0, 128);
  ASSERT_TRUE(parse_apollo_config(good, "c").has_value());
  const struct {
    const char* from;
    const char* to;
    ErrorCode code;
  } cases[] = {
      {"<?xml", "<", ErrorCode::kMalformedText},
      {"<map_config>", "<other>", ErrorCode::kMalformedText},
      {"map_ndt_v01", "lossy_map", ErrorCode::kUnsupportedFormat},
      {"<x>128", "<x>0", ErrorCode::kUnsupportedFormat},
      {"<x>128", "<x>1.5", ErrorCode::kMalformedText},
      {"<x>128", "<x>4294967296", ErrorCode::kUnsupportedFormat},
      {"<x>128", "<x>-1", ErrorCode::kUnsupportedFormat},
      {"<x>128", "<x>many", ErrorCode::kMalformedText},
      {"<x>128", "<x>", ErrorCode::kMissingField},
      {"<min_x>0", "<min_x>nan", ErrorCode::kMalformedText},
      {"<min_x>0", "<min_x>1e300", ErrorCode::kUnsupportedFormat},
      {"<resolution>1", "<resolution>0", ErrorCode::kUnsupportedFormat},
      {"<resolution>1", "<resolution>inf", ErrorCode::kMalformedText},
      {"<resolutions>", "<resolutions><resolution>1</resolution>", ErrorCode::kMalformedText},
  };
  for (const auto& one : cases) {
    std::string text = good;
    text.replace(text.find(one.from), std::string(one.from).size(), one.to);
    const Error error = failure_of(parse_apollo_config(text, "c"), one.to);
    EXPECT_EQ(error.code, one.code) << one.to << ": " << to_string(error);
  }
  EXPECT_EQ(parse_apollo_config("<map/>", "c").error().code, ErrorCode::kMissingField);
}

}  // namespace
}  // namespace sightline
