#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>

#include "formats/base/files/atomic_file.h"
#include "formats/map/container/container_writer.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/reader/map_container.h"
#include "formats/reader/reader.h"
#include "map_generated.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/map/resealed.h"
#include "tests/fuzz/repair_map.h"
#include "tests/support/value_of.h"

// Files made on purpose. Checksums are right in all of them: they are no proof against intent.

namespace sightline {
namespace {

ErrorCode refusal_of(const std::vector<std::byte>& file) {
  const Result<MapSummary> read = verify_map(file);
  EXPECT_FALSE(read.has_value());
  return read ? ErrorCode{} : read.error().code;
}

BlockParts& layer_of(TileParts& tile, const std::string& name) {
  return *std::ranges::find(tile.layers, name, &BlockParts::name);
}

CompiledMap twin_tiles() {
  CompiledMap map = random_map({.seed = 1,
                                .site_count = 2,
                                .nd_count = 2,
                                .run_count = 1,
                                .ranges_m = {10, 15, 20, 25, 30, 35, 40, 45, 50}});
  for (int i = 0; i < 2; ++i) {
    const double x_m = i == 0 ? 10.0 : 74.0;
    Nd& nd = map.ndt.nds[static_cast<std::size_t>(i)];
    nd.mean_m = {x_m, 10.0, 1.0};
    nd.key = cell_key(nd.mean_m, map.ndt.cell_m);
    map.sites.sites[static_cast<std::size_t>(i)].p_map_m = {x_m, 10.0, 1.8};
  }
  return map;
}

TEST(Attack, LayersSwappedInsideATileAreRefused) {
  ContainerParts parts = parts_of(twin_tiles());
  TileParts& tile = parts.tiles[0];
  std::swap(layer_of(tile, "ndt").raw, layer_of(tile, "range").raw);
  EXPECT_EQ(refusal_of(assemble(parts)), ErrorCode::kBadLayer);
  parts = parts_of(twin_tiles());
  BlockParts& ndt = layer_of(parts.tiles[0], "ndt");
  BlockParts& range = layer_of(parts.tiles[0], "range");
  std::swap(ndt.name, range.name);
  std::swap(ndt.version, range.version);
  EXPECT_EQ(error_class(refusal_of(assemble(parts))), ErrorClass::kCorrupt);
}

TEST(Attack, LayersSwappedBetweenTilesAreRefused) {
  for (const char* name : {"ndt", "range"}) {
    ContainerParts parts = parts_of(twin_tiles());
    std::swap(layer_of(parts.tiles[0], name).raw, layer_of(parts.tiles[1], name).raw);
    EXPECT_EQ(refusal_of(assemble(parts)), ErrorCode::kBadOrder) << name;
  }
}

TEST(Attack, TilesOfTwoVersionsMixedAreRefused) {
  const CompiledMap older = twin_tiles();
  CompiledMap newer = older;
  newer.ndt.nds[1].point_count += 1;
  ContainerParts parts = parts_of(older);
  parts.tiles[1] = parts_of(newer).tiles[1];
  const std::vector<std::byte> mixed = assemble(parts);
  const Digest root = decode_header(encode_map(older))->root_digest;
  const std::vector<std::byte> file =
      with_header(mixed, [&](FileHeader& header) { header.root_digest = root; });
  // The section look-up is sealed with the root digest that it was made for, and so fails first.
  EXPECT_EQ(refusal_of(file), ErrorCode::kBadLayer);
  std::vector<std::byte> sealed_anew = mixed;
  repair_map(sealed_anew, root);
  EXPECT_EQ(refusal_of(sealed_anew), ErrorCode::kDigestMismatch);
  EXPECT_EQ(failure_of(MapReader::open(file, "annealed")).code, ErrorCode::kChecksumMismatch);
}

TEST(Attack, ALookUpThatSendsTheVehicleElsewhereIsRefused) {
  const std::vector<std::byte> file = encode_map(twin_tiles());
  std::vector<std::byte> forged = file;
  const FileHeader header = *decode_header(file);
  const std::uint64_t rows = header.directory_offset - 2 * kPageSize;
  forged[rows] ^= std::byte{0xff};  // a site somewhere else
  seal_page(std::span(forged).subspan(rows, kPageSize), 1, page_seed(header));
  require(open_container(forged));
  // The block's own checksum differs; where that was forged too, the comparison with the layers
  // does.
  EXPECT_EQ(refusal_of(forged), ErrorCode::kChecksumMismatch);
}

TEST(Attack, ADecompressionBombIsRefusedBeforeItIsUnpacked) {
  const std::vector<std::byte> zeros(std::size_t{64} << 20);
  std::vector<std::byte> bomb(ZSTD_compressBound(zeros.size()));
  bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 1));
  ASSERT_LT(bomb.size(), std::size_t{1} << 14);
  EXPECT_EQ(failure_of(unpack_zstd(bomb, zeros.size())).code, ErrorCode::kTooLarge);

  std::vector<std::byte> file;
  const ContainerParts parts = parts_of(twin_tiles());
  ContainerWriter writer(write_to(file), parts.manifest, {});
  const PackedBlock layer{
      "debug",       1,   false, BlockCodec::kZstd, 1, zeros.size(), block_checksum(bomb),
      sha256(zeros), bomb};
  ASSERT_TRUE(writer.add_tile({0, 0}, std::vector{layer}));
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(refusal_of(file), ErrorCode::kTooLarge);
}

TEST(Attack, ARaisedRowCountIsRefusedBeforeAnythingIsAllocated) {
  ContainerParts parts = parts_of(twin_tiles());
  layer_of(parts.tiles[0], "ndt").row_count = std::uint64_t{1} << 25;
  EXPECT_EQ(refusal_of(assemble(parts)), ErrorCode::kBadLayer);
}

TEST(Attack, AFileWithoutAnEndIsRefusedAtOnce) {
  for (const char* path : {"/dev/zero", "/dev/full", "/"}) {
    EXPECT_EQ(failure_of(verify_map(std::filesystem::path(path))).code, ErrorCode::kCannotRead)
        << path;
    EXPECT_EQ(MapReader::open(std::string(path), "annealed").error().code, ErrorCode::kCannotRead)
        << path;
  }
}

TEST(Attack, APipeThatNobodyWritesToIsRefusedAtOnce) {
  const std::filesystem::path pipe =
      std::filesystem::path(testing::TempDir()) / ("pipe" + std::to_string(::getpid()));
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(MapReader::open(pipe.string(), "annealed").error().code, ErrorCode::kCannotRead);
  EXPECT_EQ(verify_map(pipe).error().code, ErrorCode::kCannotRead);
  std::filesystem::remove(pipe);
}

// A terabyte that takes no room on the disk: between a map's blocks, and behind another magic.
TEST(Attack, ALongSparseFileIsRefusedAtOnce) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / ("sparse" + std::to_string(::getpid()));
  constexpr std::uint64_t kSize = std::uint64_t{1} << 40;
  std::vector<std::byte> file = encode_map(twin_tiles());
  FileHeader header = *decode_header(file);
  const std::uint64_t moved_to = kSize - 4096;
  const std::vector<std::byte> directory(
      file.begin() + static_cast<std::ptrdiff_t>(header.directory_offset),
      file.begin() + static_cast<std::ptrdiff_t>(header.directory_offset + header.directory_size));
  header.directory_offset = moved_to;
  header.file_size = kSize;
  const std::array<std::byte, kHeaderSize> start = encode_header(header);
  const std::array<std::byte, kTrailerSize> end = encode_trailer(header, start);
  std::copy(start.begin(), start.end(), file.begin());
  ASSERT_TRUE(write_file_atomically(path, file, IfExists::kReplace));
  {
    std::fstream stream(path, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(static_cast<std::streamoff>(moved_to));
    stream.write(reinterpret_cast<const char*>(directory.data()),
                 static_cast<std::streamsize>(directory.size()));
    stream.seekp(static_cast<std::streamoff>(kSize - kTrailerSize));
    stream.write(reinterpret_cast<const char*>(end.data()), kTrailerSize);
    if (!stream) GTEST_SKIP() << "this file system has no sparse files of a terabyte";
  }
  EXPECT_EQ(verify_map(path).error().code, ErrorCode::kOutOfBounds);
  EXPECT_EQ(MapReader::open(path.string(), "annealed").error().code, ErrorCode::kBadLayer);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace sightline
