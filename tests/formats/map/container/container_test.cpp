#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "formats/map/container/container_writer.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/reader/map_layout.h"
#include "formats/reader/reader.h"
#include "map_generated.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/map/resealed.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// The full reader refuses with this code; a vehicle, which does not read the directory, need not.
std::string full_refusal(const std::vector<std::byte>& file, ErrorCode code) {
  const Result<CompiledMap> map = read_map(file);
  EXPECT_FALSE(map.has_value());
  if (map) return "";
  EXPECT_EQ(map.error().code, code) << to_string(map.error());
  (void)MapReader::open(file, "annealed");
  return to_string(map.error());
}

std::string refusal(const std::vector<std::byte>& file, ErrorCode code) {
  const Result<CompiledMap> map = read_map(file);
  const Result<MapReader> reader = MapReader::open(file, "annealed");
  EXPECT_FALSE(map.has_value());
  EXPECT_FALSE(reader.has_value());
  if (map || reader) return "";
  EXPECT_EQ(map.error().code, code) << to_string(map.error());
  EXPECT_EQ(reader.error().code, code) << to_string(reader.error());
  return to_string(map.error());
}

void expect_reads(const std::vector<std::byte>& file) {
  require(read_map(file));
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
}

const CompiledMap& small_map() {
  static const CompiledMap kMap = random_map({.seed = 1, .site_count = 5, .nd_count = 5});
  return kMap;
}

BlockParts extra_block(const std::string& name, bool is_required) {
  return {name, 3, is_required, 1, true, std::vector<std::byte>(100)};
}

TEST(MapContainer, WithAnUnknownOptionalFeatureReads) {
  ContainerParts parts = parts_of(small_map());
  parts.features = {{5, false, "seasons"}};
  expect_reads(assemble(parts));
}

TEST(MapContainer, WithAnUnknownRequiredFeatureIsRefusedByName) {
  ContainerParts parts = parts_of(small_map());
  parts.features = {{5, false, "seasons"}, {63, true, "curved-cells"}};
  EXPECT_THAT(refusal(assemble(parts), ErrorCode::kUnknownRequiredFeature),
              HasSubstr("curved-cells"));
}

TEST(MapContainer, WithAnUnknownRequiredFeatureIsRefusedByBitWhereItHasNoName) {
  const std::vector<std::byte> file = with_header(
      encode_map(small_map()), [](FileHeader& header) { header.incompatible_features = 4; });
  EXPECT_THAT(refusal(file, ErrorCode::kUnknownRequiredFeature), HasSubstr("bit 2"));
}

TEST(MapContainer, WithUnknownOptionalLayersAndSectionsReadsAndKeepsItsRootDigest) {
  const std::vector<std::byte> plain = encode_map(small_map());
  ContainerParts parts = parts_of(small_map());
  parts.tiles[0].layers.insert(parts.tiles[0].layers.begin(), extra_block("factors", false));
  parts.sections.push_back(extra_block("weather", false));
  const std::vector<std::byte> file = assemble(parts);
  expect_reads(file);
  EXPECT_EQ(verify_map(file)->root_digest, verify_map(plain)->root_digest);
}

TEST(MapContainer, WithAnUnknownRequiredLayerOrSectionIsRefusedByName) {
  ContainerParts layer = parts_of(small_map()), section = layer;
  layer.tiles[0].layers.insert(layer.tiles[0].layers.begin(), extra_block("lanes", true));
  EXPECT_THAT(refusal(assemble(layer), ErrorCode::kUnknownRequiredFeature), HasSubstr("lanes"));
  section.sections.push_back(extra_block("weather", true));
  EXPECT_THAT(refusal(assemble(section), ErrorCode::kUnknownRequiredFeature), HasSubstr("weather"));
}

TEST(MapContainer, WithALayerOfALaterVersionIsRefusedByName) {
  ContainerParts parts = parts_of(small_map());
  BlockParts& ndt = *std::ranges::find(parts.tiles[0].layers, kNdtLayer, &BlockParts::name);
  ndt.version = 2;
  EXPECT_THAT(refusal(assemble(parts), ErrorCode::kUnknownRequiredFeature),
              HasSubstr("of version 2"));
}

TEST(MapContainer, WithUnsortedTilesIsRefused) {
  ContainerParts parts = parts_of(small_map());
  ASSERT_GE(parts.tiles.size(), 2u);
  std::swap(parts.tiles[0], parts.tiles[1]);
  EXPECT_THAT(full_refusal(assemble(parts), ErrorCode::kBadOrder), HasSubstr("tile"));
}

TEST(MapContainer, WithADoubledLayerIsRefused) {
  ContainerParts parts = parts_of(small_map());
  parts.tiles[0].layers.push_back(parts.tiles[0].layers.back());
  full_refusal(assemble(parts), ErrorCode::kBadOrder);
}

TEST(MapContainer, WithACompressedRangeLayerIsRefused) {
  ContainerParts parts = parts_of(small_map());
  for (TileParts& tile : parts.tiles) {
    for (BlockParts& layer : tile.layers) layer.may_compress = true;
  }
  full_refusal(assemble(parts), ErrorCode::kBadLayer);
}

TEST(MapContainer, WithARowCountThatDoesNotFitIsRefused) {
  for (const std::uint64_t rows : {std::uint64_t{1000}, std::uint64_t{1} << 60}) {
    ContainerParts parts = parts_of(small_map());
    parts.tiles[0].layers.back().row_count = rows;
    full_refusal(assemble(parts), rows == 1000 ? ErrorCode::kBadLayer : ErrorCode::kTooLarge);
  }
}

TEST(MapContainer, WithAManifestOrDirectoryOutsideTheFileIsRefused) {
  for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{129}, ~std::uint64_t{63}}) {
    refusal(with_header(encode_map(small_map()),
                        [&](FileHeader& header) { header.manifest_offset = offset; }),
            ErrorCode::kOutOfBounds);
    full_refusal(with_header(encode_map(small_map()),
                             [&](FileHeader& header) { header.directory_offset = offset; }),
                 ErrorCode::kOutOfBounds);
  }
}

TEST(MapContainer, WithAManifestThatIsNoFlatBufferIsRefused) {
  ContainerParts parts = parts_of(small_map());
  for (TileParts& tile : parts.tiles) {
    for (BlockParts& layer : tile.layers) layer.may_compress = false;  // which takes long
  }
  parts.sections.clear();
  for (std::size_t i = 0; i < parts.manifest.size(); ++i) {
    ContainerParts damaged = parts;
    damaged.manifest[i] ^= std::byte{0x81};
    const std::vector<std::byte> file = assemble(damaged);
    (void)read_map(file);
    (void)MapReader::open(file, "annealed");
  }
  std::ranges::fill(parts.manifest, std::byte{0xff});
  refusal(assemble(parts), ErrorCode::kBadManifest);
}

// The manifest with a vector of one of its tables once more at its end, where its elements lie at
// no multiple of 8. A table is chosen by its first byte.
std::vector<std::byte> with_misaligned(std::vector<std::byte> manifest, const void* table,
                                       flatbuffers::voffset_t field, std::size_t element_size) {
  const std::uint8_t* address = static_cast<const flatbuffers::Table*>(table)->GetAddressOf(field);
  const std::uint8_t* vector = address + flatbuffers::ReadScalar<flatbuffers::uoffset_t>(address);
  const auto count = flatbuffers::ReadScalar<flatbuffers::uoffset_t>(vector);
  const auto* first = reinterpret_cast<const std::byte*>(vector);
  const std::vector<std::byte> copy(first, first + sizeof count + count * element_size);
  const auto at =
      static_cast<std::size_t>(reinterpret_cast<const std::byte*>(address) - manifest.data());
  manifest.resize((manifest.size() + 7) / 8 * 8);
  const auto distance = static_cast<flatbuffers::uoffset_t>(manifest.size() - at);
  std::memcpy(manifest.data() + at, &distance, sizeof distance);
  manifest.insert(manifest.end(), copy.begin(), copy.end());
  return manifest;
}

TEST(MapContainer, WithMisalignedNumbersInItsManifestIsRefused) {
  const ContainerParts parts = parts_of(small_map());
  ContainerParts damaged = parts;
  const auto refuses = [&](auto table_of, flatbuffers::voffset_t field, std::size_t element_size) {
    std::vector<std::byte> manifest = parts.manifest;
    const void* table = table_of(*flatbuffers::GetRoot<schema::Manifest>(manifest.data()));
    damaged.manifest = with_misaligned(std::move(manifest), table, field, element_size);
    EXPECT_THAT(refusal(assemble(damaged), ErrorCode::kBadManifest), HasSubstr("misaligned"));
  };
  using schema::Manifest;
  refuses([](const Manifest& manifest) { return &manifest; }, Manifest::VT_RANGES_M,
          sizeof(double));
  refuses([](const Manifest& manifest) { return manifest.sensor(); },
          schema::Sensor::VT_BEAM_ELEVATIONS_DEG, sizeof(double));
  refuses([](const Manifest& manifest) { return manifest.measurement(); },
          schema::Measurement::VT_OFFSETS, sizeof(schema::Offset));
}

TEST(MapContainer, WithNoNumbersInAVectorOfItsManifestReads) {
  CompiledMap map = small_map();  // where an empty vector lies does not matter
  map.measurement.offsets.clear();
  expect_reads(encode_map(map));
}

TEST(MapContainer, SentAsTextIsNoMap) {
  std::vector<std::byte> file = encode_map(small_map());
  std::erase(file, std::byte{'\r'});
  refusal(file, ErrorCode::kBadMagic);
  refusal({}, ErrorCode::kTruncatedFile);
  refusal(std::vector<std::byte>(4096), ErrorCode::kBadMagic);
}

}  // namespace
}  // namespace sightline
