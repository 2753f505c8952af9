#include "formats/map/container_writer.h"

#include <algorithm>
#include <utility>

#include "formats/map/block_codec.h"
#include "formats/map/map_digests.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

using BlockOffset = flatbuffers::Offset<schema::Block>;
using BlockOffsets = flatbuffers::Offset<flatbuffers::Vector<BlockOffset>>;

schema::Digest to_schema(const Digest& digest) {
  return schema::Digest(flatbuffers::span<const std::uint8_t, 32>(digest));
}

// Appends to the file, at the next multiple of kAlignment; returns where.
std::uint64_t append_aligned(std::vector<std::byte>& file, std::span<const std::byte> bytes) {
  file.resize(aligned(file.size()));
  const std::uint64_t offset = file.size();
  file.insert(file.end(), bytes.begin(), bytes.end());
  return offset;
}

BlockName name_of(const BlockParts& block) {
  return {block.name, block.version, block.row_count, sha256(block.raw)};
}

BlockOffset append_block(const BlockParts& block, const Digest& raw_digest,
                         std::vector<std::byte>& file, flatbuffers::FlatBufferBuilder& builder) {
  const StoredBlock stored = block.may_compress ? pack(block.raw) : StoredBlock{{}, block.raw};
  const std::uint64_t offset = append_aligned(file, stored.bytes);
  const schema::Digest digest = to_schema(raw_digest);
  return schema::CreateBlockDirect(builder, block.name.c_str(), block.version, block.is_required,
                                   block.row_count, offset, stored.bytes.size(), block.raw.size(),
                                   static_cast<schema::Codec>(stored.codec), &digest,
                                   block_checksum(stored.bytes));
}

// Writes the blocks and their entries; collects the names of the required ones.
BlockOffsets append_blocks(const std::vector<BlockParts>& blocks, std::vector<std::byte>& file,
                           flatbuffers::FlatBufferBuilder& builder,
                           std::vector<BlockName>& required) {
  std::vector<BlockOffset> offsets;
  for (const BlockParts& block : blocks) {
    const BlockName name = name_of(block);
    if (block.is_required) required.push_back(name);
    offsets.push_back(append_block(block, name.raw_digest, file, builder));
  }
  return builder.CreateVector(offsets);
}

std::vector<flatbuffers::Offset<schema::Feature>> append_features(
    const std::vector<FeatureParts>& features, flatbuffers::FlatBufferBuilder& builder,
    FileHeader& header) {
  std::vector<flatbuffers::Offset<schema::Feature>> offsets;
  for (const FeatureParts& feature : features) {
    std::uint64_t& bits =
        feature.is_required ? header.incompatible_features : header.compatible_features;
    bits |= std::uint64_t{1} << feature.bit;
    offsets.push_back(schema::CreateFeatureDirect(builder, feature.bit, feature.is_required,
                                                  feature.name.c_str()));
  }
  return offsets;
}

std::span<const std::byte> finished(const flatbuffers::FlatBufferBuilder& builder) {
  return std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
}

// Header and trailer around everything else, which is in place.
void seal_file(const FileHeader& header, std::vector<std::byte>& file) {
  const std::array<std::byte, kHeaderSize> start = encode_header(header);
  const std::array<std::byte, kTrailerSize> end = encode_trailer(header, start);
  std::copy(start.begin(), start.end(), file.begin());
  file.insert(file.end(), end.begin(), end.end());
}

}  // namespace

std::vector<std::byte> assemble(const ContainerParts& parts) {
  FileHeader header;
  std::vector<std::byte> file(kHeaderSize);
  header.manifest_offset = append_aligned(file, parts.manifest);
  header.manifest_size = parts.manifest.size();
  header.manifest_checksum = block_checksum(parts.manifest);

  flatbuffers::FlatBufferBuilder builder;
  std::vector<Digest> tile_digests;
  std::vector<flatbuffers::Offset<schema::Tile>> tiles;
  for (const TileParts& tile : parts.tiles) {
    std::vector<BlockName> required;
    const BlockOffsets layers = append_blocks(tile.layers, file, builder, required);
    tile_digests.push_back(tile_digest(tile.key, required));
    const schema::Digest digest = to_schema(tile_digests.back());
    tiles.push_back(schema::CreateTile(builder, tile.key.x, tile.key.y, &digest, layers));
  }
  std::vector<BlockName> required_sections;
  const BlockOffsets sections = append_blocks(parts.sections, file, builder, required_sections);
  const auto features = builder.CreateVector(append_features(parts.features, builder, header));
  builder.Finish(schema::CreateDirectory(builder, features, builder.CreateVector(tiles), sections));

  header.directory_offset = append_aligned(file, finished(builder));
  header.directory_size = builder.GetSize();
  header.directory_checksum = block_checksum(finished(builder));
  file.resize(aligned(file.size()));
  header.file_size = file.size() + kTrailerSize;
  header.root_digest = root_digest(sha256(parts.manifest), header.incompatible_features,
                                   tile_digests, required_sections);
  seal_file(header, file);
  return file;
}

}  // namespace sightline
