#include "formats/map/packed_nds.h"

#include <gtest/gtest.h>

#include <vector>

#include "formats/base/random.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/map/packed_model.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::string text_of(const NdtMap& map) { return format_table(dump(map), TableFormat::kCsv); }

std::vector<std::byte> sealed(const PackedNds& nds) {
  std::vector<std::byte> bytes;
  const auto take = [&](std::span<const std::byte> piece) -> Result<void> {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
    return {};
  };
  EXPECT_TRUE(visit_bytes(nds, take));
  return bytes;
}

TEST(PackedNds, AreThoseOfTheMapFile) {
  for (const int count : {0, 1, 7, 300}) {
    CompiledMap map = random_map({.seed = 3, .nd_count = count});
    const PackedNds nds = value_of(pack_nds(map.ndt));
    EXPECT_EQ(nds.nd_count, map.ndt.nds.size());
    EXPECT_TRUE(validate(nds));
    EXPECT_EQ(text_of(value_of(unpacked(nds))), text_of(read_map(encode_map(map))->ndt));
    const CompiledMap whole = map;
    const ByFamily<StoredTable<FactorTable>> factors = factors_of(map);
    const PackedModel model = value_of(pack_model(map.model));
    map.model = model.record;
    map.ndt = without_nds(nds);
    map.factors = {};
    std::vector<std::byte> file;
    ASSERT_TRUE(write_map({map, nds, model, factors}, write_to(file)));
    EXPECT_EQ(file, encode_map(whole));
  }
}

TEST(PackedNds, ComeBackFromTheirBytesAndFromAFile) {
  const PackedNds nds = value_of(pack_nds(random_map({.seed = 4, .nd_count = 200}).ndt));
  const std::vector<std::byte> bytes = sealed(nds);
  const PackedNds back = value_of(from_stored<PackedNds>(StoredBytes(bytes)));
  EXPECT_EQ(sealed(back), bytes);
  EXPECT_EQ(text_of(*unpacked(back)), text_of(*unpacked(nds)));
}

// Whatever byte is wrong, sealed anew so that only the decoder can see it: an error, or NDs that
// hold together.
TEST(PackedNds, RefuseDamageBelowTheSeal) {
  const PackedNds nds = value_of(pack_nds(random_map({.seed = 5, .nd_count = 60}).ndt));
  std::vector<std::byte> payload;
  ASSERT_TRUE(visit_payload(nds, [&](std::span<const std::byte> piece) -> Result<void> {
    payload.insert(payload.end(), piece.begin(), piece.end());
    return {};
  }));
  int refused = 0;
  for (std::size_t i = 0; i < payload.size(); ++i) {
    std::vector<std::byte> damaged = payload;
    damaged[i] ^= std::byte{1};
    PackedNds read;
    const Result<void> opened = open_payload(StoredBytes(damaged), read);
    refused += opened ? 0 : 1;
    EXPECT_TRUE(!opened || validate(read));
  }
  // The frame's origin and three counts may be any number, cells and tiles may be wider by a hair.
  EXPECT_GE(refused, static_cast<int>(payload.size()) - 64);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    PackedNds read;
    const std::vector<std::byte> cut(payload.begin(),
                                     payload.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(open_payload(StoredBytes(cut), read));
  }
}

TEST(PackedNds, RefuseTilesThatDoNotAscend) {
  PackedNds nds = value_of(pack_nds(random_map({.seed = 6, .nd_count = 200}).ndt));
  ASSERT_GE(nds.tiles.size(), 2u);
  std::swap(nds.tiles.front(), nds.tiles.back());
  EXPECT_EQ(failure_of(validate(nds)).code, ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
