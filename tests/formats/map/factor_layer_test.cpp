#include "formats/map/factor_layer.h"

#include <gtest/gtest.h>

#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

FactorTable small_table() {
  FactorTable table;
  table.looks = every_return_at({10.0, 20.0});
  table.factors = {"feature_count", "crlb_max"};
  table.site_count = 3;
  for (int i = 0; i < 12; ++i) table.values.push_back(i);
  return table;
}

TEST(FactorLayer, KeepsTheRowsOfItsSites) {
  const FactorTable table = small_table();
  const std::vector<std::uint32_t> sites = {0, 2};
  const std::vector<std::byte> raw = encode_factor_layer(table, sites);
  EXPECT_EQ(raw.size() % 64, 0U);
  FactorTable back = table;
  back.values.assign(12, -1.0);
  std::vector<bool> is_filled(3);
  ASSERT_TRUE(decode_factor_layer(raw, 2, back, is_filled));
  EXPECT_EQ(is_filled, (std::vector<bool>{true, false, true}));
  EXPECT_EQ(back.values, (std::vector<double>{0, 1, 2, 3, -1, -1, -1, -1, 8, 9, 10, 11}));
}

TEST(FactorLayer, RefusesDoubledAndUnknownSitesAndWrongSizes) {
  const FactorTable table = small_table();
  FactorTable back = table;
  std::vector<bool> is_filled = {true, false, false};
  const std::vector<std::byte> first = encode_factor_layer(table, std::vector<std::uint32_t>{0});
  EXPECT_EQ(decode_factor_layer(first, 1, back, is_filled).error().code, ErrorCode::kBadOrder);
  std::vector<bool> none;
  EXPECT_EQ(decode_factor_layer(first, 1, back, none).error().code, ErrorCode::kBadOrder);
  EXPECT_EQ(decode_factor_layer(first, 100, back, is_filled).error().code, ErrorCode::kBadLayer);
}

TEST(FactorLayer, KeepsNamesAndRefusesOtherNumbersOfThem) {
  const FactorTable table = small_table();
  FactorTable back = table;
  back.factors = {"", ""};
  const std::vector<std::byte> raw = encode_factor_names(table);
  ASSERT_TRUE(decode_factor_names(raw, back));
  EXPECT_EQ(back.factors, table.factors);
  back.factors = {""};
  EXPECT_EQ(decode_factor_names(raw, back).error().code, ErrorCode::kBadLayer);
}

TEST(FactorLayer, IsPartOfAMapAndChangesNoDigestThatAVehicleReliesOn) {
  const CompiledMap map = random_map({.seed = 3});
  CompiledMap bare = map;
  bare.factors = {};
  const std::vector<std::byte> file = encode_map(map);
  EXPECT_EQ(to_bytes(value_of(read_map(file)).factors), to_bytes(map.factors));
  const std::vector<std::byte> bare_file = encode_map(bare);
  EXPECT_TRUE(read_map(bare_file)->factors.factors.empty());
  EXPECT_LT(bare_file.size(), file.size());
  EXPECT_EQ(verify_map(file)->root_digest, verify_map(bare_file)->root_digest);
}

}  // namespace
}  // namespace sightline
