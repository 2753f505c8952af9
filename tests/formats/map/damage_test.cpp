#include <gtest/gtest.h>

#include "formats/map/container/container_writer.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

CompiledMap tiny_map() {
  return random_map(
      {.seed = 2, .site_count = 3, .nd_count = 4, .has_columns = true, .model_size = 90});
}

TEST(DamagedMap, CutShortAtAnyByteIsRefused) {
  const std::vector<std::byte> file = encode_map(tiny_map());
  for (std::size_t size = 0; size < file.size(); ++size) {
    const Result<MapSummary> cut = verify_map(std::span(file).first(size));
    ASSERT_FALSE(cut) << "accepted at " << size;
    ASSERT_EQ(cut.error().code, ErrorCode::kTruncatedFile) << "cut at " << size;
  }
}

TEST(DamagedMap, WithBytesAppendedIsRefused) {
  std::vector<std::byte> file = encode_map(tiny_map());
  file.push_back(std::byte{0});
  EXPECT_EQ(failure_of(verify_map(file)).code, ErrorCode::kOutOfBounds);
}

TEST(DamagedMap, WithOneBitFlippedInAnyByteIsRefusedAndTellsWhere) {
  const std::vector<std::byte> file = encode_map(tiny_map());
  for (std::size_t i = 0; i < file.size(); ++i) {
    std::vector<std::byte> damaged = file;
    damaged[i] ^= std::byte(1 << (i % 8));
    const Result<MapSummary> read = verify_map(damaged);
    ASSERT_FALSE(read) << "accepted a flip in byte " << i;
    ASSERT_EQ(error_class(read.error().code), ErrorClass::kCorrupt) << to_string(read.error());
    ASSERT_FALSE(read.error().place.empty()) << to_string(read.error());
  }
}

TEST(DamagedMap, NamesTheTileAndLayerOfTheFault) {
  ContainerParts parts = parts_of(tiny_map());
  for (TileParts& tile : parts.tiles) {
    for (BlockParts& layer : tile.layers) {
      if (layer.name == "range") layer.raw[0] ^= std::byte{0x40};  // a site that is not there
    }
  }
  const Error error = failure_of(read_map(assemble(parts)));
  EXPECT_EQ(error.code, ErrorCode::kBadOrder);
  EXPECT_NE(error.place.find("layer range, byte "), std::string::npos) << error.place;
  EXPECT_NE(error.place.find(", row 0, site "), std::string::npos) << error.place;
  EXPECT_EQ(error.place.rfind("tile ", 0), 0u) << error.place;
}

// Sealed with right checksums and digests: what a mistaken writer could make.
TEST(DamagedMap, BelowItsChecksumsNeverCrashesItsReader) {
  ContainerParts parts = parts_of(tiny_map());
  for (TileParts& tile : parts.tiles) {
    for (BlockParts& layer : tile.layers) layer.may_compress = false;  // which takes long
  }
  parts.sections.clear();
  for (std::size_t t = 0; t < parts.tiles.size(); ++t) {
    for (std::size_t l = 0; l < parts.tiles[t].layers.size(); ++l) {
      for (std::size_t i = 0; i < parts.tiles[t].layers[l].raw.size(); i += 3) {
        ContainerParts damaged = parts;
        damaged.tiles[t].layers[l].raw[i] ^= std::byte{0xff};
        const Result<CompiledMap> map = read_map(assemble(damaged));
        EXPECT_TRUE(!map || validate(*map));
      }
    }
  }
}

}  // namespace
}  // namespace sightline
