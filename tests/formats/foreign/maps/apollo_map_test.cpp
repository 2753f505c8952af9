#include "formats/foreign/maps/apollo_map.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "formats/base/random.h"
#include "formats/foreign/maps/apollo_config.h"
#include "formats/foreign/maps/apollo_node.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/formats/foreign/maps/apollo_writer.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

// A node of two by two cells of 1 m: one of 12 points, one of a single one.
ApolloTestNode small_node() {
  ApolloTestNode node{2, 2, {}};
  ApolloTestCell cell{12, {0.25, 0.5, 0.75}, {}};
  cell.products_m2 = cell.mean_m * cell.mean_m.transpose() +
                     Eigen::Matrix3d(Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal());
  node.cells[{0, 1, 3}] = cell;
  node.cells[{1, 0, -2}] = {1, {0.5, 0.5, -0.5}, Eigen::Matrix3d::Constant(0.25)};
  return node;
}

ApolloConfig plain_config() { return *parse_apollo_config(apollo_config(1.0, 2, false), "c"); }

Result<ApolloNode> parse(const std::string& file, const ApolloConfig& config = plain_config()) {
  return parse_apollo_node(bytes_of(file), config, {0, 10, 0, 0}, "node");
}

// Of the cells of a grid, by brute force.
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
    const Result<ForeignNds> map = open_apollo_map(folder_.path(), 1);
    ASSERT_FALSE(map.has_value());
    EXPECT_EQ(map.error().code, code) << to_string(map.error());
    EXPECT_THAT(to_string(map.error()), HasSubstr(part));
  }
  ScratchFolder folder_;
};

// In the middle of a zone, over and under zero and across it, on four nodes.
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
    const Result<ForeignNds> map = open_apollo_map(folder_.path(), 2);
    ASSERT_TRUE(map.has_value()) << to_string(map.error());
    ASSERT_TRUE(validate(*map).has_value());
    EXPECT_EQ(map->world, "utm:10N");
    EXPECT_EQ(map->cell_m, cell_m);
    EXPECT_EQ(map->point_count, points_m.size());
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
    EXPECT_EQ(map->single_point_count, single_count);
    ASSERT_EQ(map->nds.size(), expected.size());
    for (const ForeignNd& nd : map->nds) {
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
  const Result<ForeignNds> map = open_apollo_map(folder_.path(), 1);
  ASSERT_TRUE(map.has_value()) << to_string(map.error());
  EXPECT_EQ(map->world, "utm:33S");
  EXPECT_EQ(map->name, folder_.path().filename().string());
  const auto files = list_apollo_map(folder_ / "config.xml");
  ASSERT_TRUE(files.has_value());
  EXPECT_GT(files->size(), 2U);
  EXPECT_EQ(files->front().filename(), "config.xml");
  EXPECT_EQ(open_apollo_map(folder_ / "config.xml", 2)->digest, map->digest);
  write_points(random_points(2), 1.0, -33);
  EXPECT_NE(open_apollo_map(folder_.path(), 1)->digest, map->digest);
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
  const Result<ForeignNds> map = open_apollo_map(folder_.path(), 1);
  ASSERT_TRUE(map.has_value()) << to_string(map.error());
  EXPECT_EQ(map->cell_m, 1.0);
  ASSERT_EQ(map->nds.size(), 1U);
  EXPECT_EQ(map->nds[0].key_world, (CellKey{15, 10, 3}));
  ASSERT_EQ(map->warnings.size(), 1U);
  EXPECT_THAT(map->warnings[0], HasSubstr("3 resolutions; cells of 1 m"));
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
  expect_error(ErrorCode::kUnsupportedFormat, "no multiple of a cell");
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
    const Result<ApolloConfig> config = parse_apollo_config(text, "c");
    ASSERT_FALSE(config.has_value()) << one.to;
    EXPECT_EQ(config.error().code, one.code) << one.to << ": " << to_string(config.error());
  }
  EXPECT_EQ(parse_apollo_config("<map/>", "c").error().code, ErrorCode::kMissingField);
}

TEST(ApolloNode, IsReadPlainAndPacked) {
  const std::string body = apollo_body(small_node());
  ApolloConfig packed = plain_config();
  packed.is_compressed = true;
  const Result<ApolloNode> plain = parse(apollo_file({}, body));
  const Result<ApolloNode> unpacked = parse(apollo_file({}, zlib_packed(body)), packed);
  ASSERT_TRUE(plain.has_value()) << to_string(plain.error());
  ASSERT_TRUE(unpacked.has_value()) << to_string(unpacked.error());
  for (const ApolloNode& node : {*plain, *unpacked}) {
    EXPECT_EQ(node.single_point_count, 1U);
    EXPECT_EQ(node.point_count, 13U);
    ASSERT_EQ(node.nds.size(), 1U);
    EXPECT_EQ(node.nds[0].key_world, (CellKey{1, 0, 3}));
    EXPECT_NEAR(node.nds[0].covariance_m2(2, 2), 0.03 * 12 / 11, 1e-6);
  }
}

TEST(ApolloNode, CutAnywhereIsRefused) {
  const std::string body = apollo_body(small_node());
  const std::string plain = apollo_file({}, body);
  for (std::size_t size = 0; size < plain.size(); ++size) {
    const Result<ApolloNode> node = parse(plain.substr(0, size));
    ASSERT_FALSE(node.has_value()) << size;
    EXPECT_EQ(node.error().code, ErrorCode::kTruncatedScan) << to_string(node.error());
  }
  for (std::size_t size = 0; size < body.size(); ++size) {
    EXPECT_FALSE(parse(apollo_file({}, body.substr(0, size))).has_value()) << size;
  }
  ApolloConfig packed = plain_config();
  packed.is_compressed = true;
  const std::string stream = zlib_packed(body);
  for (std::size_t size = 0; size < stream.size(); ++size) {
    EXPECT_FALSE(parse(apollo_file({}, stream.substr(0, size)), packed).has_value()) << size;
  }
  EXPECT_EQ(parse(plain + "x").error().code, ErrorCode::kMalformedHeader);
  EXPECT_EQ(parse(apollo_file({}, body + "x")).error().code, ErrorCode::kMalformedHeader);
  EXPECT_EQ(parse(apollo_file({}, stream + "x"), packed).error().code, ErrorCode::kMalformedHeader);
}

TEST(ApolloNode, DamagedAnywhereIsRefusedOrHoldsWhatPointsHave) {
  const std::string plain = apollo_file({}, apollo_body(small_node()));
  for (std::size_t i = 0; i < plain.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xff}) {
      std::string damaged = plain;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      const Result<ApolloNode> node = parse(damaged);
      if (!node) {
        EXPECT_EQ(error_class(node.error().code), ErrorClass::kInput);
        continue;
      }
      for (const ForeignNd& nd : node->nds) {
        EXPECT_TRUE(nd.covariance_m2.allFinite()) << i;
        EXPECT_GE(nd.mean_in_cell_m.minCoeff(), 0.0) << i;
        EXPECT_LT(nd.mean_in_cell_m.maxCoeff(), 1.0) << i;
        EXPECT_GE(nd.point_count, 2U) << i;
      }
    }
  }
}

TEST(ApolloNode, AnotherNodeThanItsFoldersSayIsRefused) {
  const std::string body = apollo_body(small_node());
  for (const ApolloTestIndex& index : {ApolloTestIndex{1, 10, 0, 0},
                                       {0, 11, 0, 0},
                                       {0, -10, 0, 0},
                                       {0, 10, 1, 0},
                                       {0, 10, 0, 1}}) {
    const Result<ApolloNode> node = parse(apollo_file(index, body));
    ASSERT_FALSE(node.has_value());
    EXPECT_EQ(node.error().code, ErrorCode::kMalformedHeader);
  }
  ApolloTestNode larger = small_node();
  larger.rows = 3;
  EXPECT_THAT(to_string(parse(apollo_file({}, apollo_body(larger))).error()),
              HasSubstr("found 3 rows of 2, expected 2 of 2"));
}

// 2^32 - 1 cells, or points on the road, in a column of none.
TEST(ApolloNode, CountsBeyondTheFileAskForNoMemory) {
  const std::string empty = apollo_body({2, 2, {}});
  for (const std::size_t at : {std::size_t{8}, std::size_t{20}}) {
    std::string body = empty;
    body.replace(at, 4, "\xff\xff\xff\xff");
    EXPECT_EQ(parse(apollo_file({}, body)).error().code, ErrorCode::kTruncatedScan) << at;
  }
}

TEST(ApolloNode, ABodyThatUnpacksToMoreThanANodeIsRefused) {
  ApolloConfig packed = plain_config();
  packed.is_compressed = true;
  const std::string bomb = zlib_packed(std::string(4'000'000, '\0'));
  ASSERT_LT(bomb.size(), 5000U);
  EXPECT_EQ(parse(apollo_file({}, bomb), packed).error().code, ErrorCode::kUnsupportedFormat);
}

TEST(ApolloNode, NumbersThatNoPointsHaveAreLeftOutAndCounted) {
  const double nan = std::nan("");
  const ApolloTestCell good = small_node().cells.begin()->second;
  std::vector<ApolloTestCell> bad(6, good);
  bad[0].count = 0x80000000U;  // negative for whoever reads it so
  bad[1].mean_m.y() = nan;
  bad[2].products_m2(1, 2) = nan;
  bad[3].mean_m.x() = 100.0;
  bad[4].products_m2(2, 2) = -1.0;
  bad[5].products_m2(0, 0) = 50.0;
  for (const ApolloTestCell& cell : bad) {
    ApolloTestNode node = small_node();
    node.cells.begin()->second = cell;
    const Result<ApolloNode> read = parse(apollo_file({}, apollo_body(node)));
    ASSERT_TRUE(read.has_value()) << to_string(read.error());
    EXPECT_TRUE(read->nds.empty());
    EXPECT_EQ(read->damaged_count, 1U);
  }
}

}  // namespace
}  // namespace sightline
