#include "formats/foreign/maps/apollo_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "tests/formats/foreign/maps/apollo_writer.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

ApolloConfig plain_config() { return *parse_apollo_config(apollo_config(1.0, 2, false), "c"); }

Result<ApolloNode> parse(const std::string& file, const ApolloConfig& config = plain_config()) {
  return parse_apollo_node(bytes_of(file), config, {0, 10, 0, 0}, "node");
}

TEST(ApolloNode, IsReadPlainAndPacked) {
  const std::string body = apollo_body(small_node());
  ApolloConfig packed = plain_config();
  packed.is_compressed = true;
  const ApolloNode plain = value_of(parse(apollo_file({}, body)));
  const ApolloNode unpacked = value_of(parse(apollo_file({}, zlib_packed(body)), packed));
  for (const ApolloNode& node : {plain, unpacked}) {
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
    const Error error = failure_of(parse(plain.substr(0, size)), size);
    EXPECT_EQ(error.code, ErrorCode::kTruncatedScan) << to_string(error);
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
    EXPECT_EQ(failure_of(parse(apollo_file(index, body))).code, ErrorCode::kMalformedHeader);
  }
  ApolloTestNode larger = small_node();
  larger.rows = 3;
  EXPECT_THAT(to_string(parse(apollo_file({}, apollo_body(larger))).error()),
              HasSubstr("found 3 rows of 2, expected 2 of 2"));
}

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
  std::vector<ApolloTestCell> bad(6, small_node().cells.begin()->second);
  bad[0].count = 0x80000000U;  // negative for a reader that takes it for signed
  bad[1].mean_m.y() = nan;
  bad[2].products_m2(1, 2) = nan;
  bad[3].mean_m.x() = 100.0;
  bad[4].products_m2(2, 2) = -1.0;
  bad[5].products_m2(0, 0) = 50.0;
  for (const ApolloTestCell& cell : bad) {
    ApolloTestNode node = small_node();
    node.cells.begin()->second = cell;
    const ApolloNode read = value_of(parse(apollo_file({}, apollo_body(node))));
    EXPECT_TRUE(read.nds.empty());
    EXPECT_EQ(read.damaged_count, 1U);
  }
}

}  // namespace
}  // namespace sightline
