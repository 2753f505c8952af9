#include "formats/map/container/container_writer.h"

#include <algorithm>
#include <utility>

#include "formats/map/container/contents_layer.h"
#include "formats/map/container/look_up_writer.h"
#include "formats/map/container/packed_block.h"
#include "formats/reader/look_up.h"
#include "formats/reader/map_checks.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

using BlockOffset = flatbuffers::Offset<schema::Block>;

schema::Digest to_schema(const Digest& digest) {
  return schema::Digest(flatbuffers::span<const std::uint8_t, 32>(digest));
}

BlockName name_of(const PackedBlock& block) {
  return {block.name, block.version, block.row_count, block.raw_digest};
}

std::vector<flatbuffers::Offset<schema::Feature>> append_features(
    const std::vector<FeatureParts>& features, flatbuffers::FlatBufferBuilder& builder,
    FileHeader& header) {
  std::vector<flatbuffers::Offset<schema::Feature>> offsets;
  for (const FeatureParts& feature : features) {
    (feature.is_required ? header.incompatible_features : header.compatible_features) |=
        std::uint64_t{1} << feature.bit;
    offsets.push_back(schema::CreateFeatureDirect(builder, feature.bit, feature.is_required,
                                                  feature.name.c_str()));
  }
  return offsets;
}

std::span<const std::byte> finished(const flatbuffers::FlatBufferBuilder& builder) {
  return std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
}

// None where the manifest is none: the writer puts together what it is given.
std::optional<LookUpBuilder> look_up_builder(std::span<const std::byte> manifest) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(manifest.data());
  flatbuffers::Verifier verifier(data, manifest.size());
  if (!verifier.VerifyBuffer<schema::Manifest>(nullptr)) return std::nullopt;
  const auto& root = *flatbuffers::GetRoot<schema::Manifest>(data);
  if (!check_manifest(root)) return std::nullopt;
  return LookUpBuilder(answer_shape(root), root.reach_m());
}

PackedBlock plain_block(std::string_view name, std::uint32_t version, std::uint64_t row_count,
                        std::span<const std::byte> bytes) {
  return {std::string(name),     version,       false, BlockCodec::kNone, row_count, bytes.size(),
          block_checksum(bytes), sha256(bytes), bytes};
}

// False where it is no range layer whose sites can be looked up.
bool add_to_look_up(const PackedBlock& layer, LookUpBuilder& look_up) {
  if (layer.version != kRangeLayerVersion || layer.row_count > kMostRows) return false;
  if (layer.codec == BlockCodec::kNone) return look_up.add(layer.stored, layer.row_count);
  const Result<std::vector<std::byte>> raw =
      unpack(layer.codec, layer.stored, layer.row_count, layer.raw_size);
  return raw && look_up.add(*raw, layer.row_count);
}

}  // namespace

SelfContainedBlock packed(const BlockParts& parts) {
  SelfContainedBlock packed;
  packed.stored = parts.stored         ? *parts.stored
                  : parts.may_compress ? pack(parts.raw)
                                       : StoredBlock{{}, parts.raw};
  packed.block = {parts.name,
                  parts.version,
                  parts.is_required,
                  packed.stored.codec,
                  parts.row_count,
                  parts.raw.size(),
                  block_checksum(packed.stored.bytes),
                  sha256(parts.raw),
                  packed.stored.bytes};
  return packed;
}

struct ContainerWriter::State {
  Write write;
  std::vector<FeatureParts> features;
  FileHeader header;
  Digest manifest_digest{};
  std::uint64_t end = 0;  // of what is written so far
  flatbuffers::FlatBufferBuilder builder;
  std::vector<Digest> tile_digests;
  std::vector<flatbuffers::Offset<schema::Tile>> tiles;
  std::vector<BlockName> required_sections;
  std::vector<BlockOffset> sections;
  BlockKinds required_kinds;
  std::optional<LookUpBuilder> look_up;
  Result<void> status;  // of the first write, which the constructor did

  Result<std::uint64_t> append(std::span<const std::byte> bytes, std::uint64_t alignment);
  Result<BlockOffset> append_block(const PackedBlock& block, std::uint64_t alignment = kAlignment);
  Result<void> append_look_up();
  Result<void> append_end(std::span<const std::byte> directory);
};

// Zeros up to the alignment, then the bytes; returns where these lie.
Result<std::uint64_t> ContainerWriter::State::append(std::span<const std::byte> bytes,
                                                     std::uint64_t alignment) {
  const std::uint64_t offset = (end + alignment - 1) / alignment * alignment;
  const std::vector<std::byte> gap(offset - end);
  SIGHTLINE_TRY(gap.empty() ? Result<void>() : write(end, gap));
  SIGHTLINE_TRY(bytes.empty() ? Result<void>() : write(offset, bytes));
  end = offset + bytes.size();
  return offset;
}

Result<BlockOffset> ContainerWriter::State::append_block(const PackedBlock& block,
                                                         std::uint64_t alignment) {
  SIGHTLINE_ASSIGN(const std::uint64_t offset, append(block.stored, alignment));
  if (block.is_required) required_kinds.insert({block.name, block.version});
  const schema::Digest digest = to_schema(block.raw_digest);
  return schema::CreateBlockDirect(builder, block.name.c_str(), block.version, block.is_required,
                                   block.row_count, offset, block.stored.size(), block.raw_size,
                                   static_cast<schema::Codec>(block.codec), &digest,
                                   block.stored_checksum);
}

// The last section, whatever the names of others: else it could not be found without the
// directory. Parts that no look-up can be made of are no map; readers say why.
Result<void> ContainerWriter::State::append_look_up() {
  if (!look_up) return {};
  const std::vector<std::byte> section = look_up->finish(header, required_kinds);
  if (section.empty()) return {};
  SIGHTLINE_ASSIGN(const BlockOffset block,
                   append_block(plain_block(kLookUpSection, kLookUpSectionVersion,
                                            section.size() / kPageSize, section),
                                kPageSize));
  sections.push_back(block);
  features.insert(features.begin(), {kLookUpFeatureBit, false, std::string(kLookUpSection)});
  return {};
}

// Directory and trailer, and the header at the front.
Result<void> ContainerWriter::State::append_end(std::span<const std::byte> directory) {
  SIGHTLINE_ASSIGN(header.directory_offset, append(directory, kAlignment));
  header.directory_size = directory.size();
  header.directory_checksum = block_checksum(directory);
  header.file_size = aligned(end) + kTrailerSize;
  const std::array<std::byte, kHeaderSize> start = encode_header(header);
  SIGHTLINE_TRY(append(encode_trailer(header, start), kAlignment));
  return write(0, start);
}

ContainerWriter::ContainerWriter(Write write, std::vector<std::byte> manifest,
                                 std::vector<FeatureParts> features)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.write = std::move(write);
  state.features = std::move(features);
  state.look_up = look_up_builder(manifest);
  state.manifest_digest = sha256(manifest);
  const std::array<std::byte, kHeaderSize> room{};
  const Result<std::uint64_t> start = state.append(room, kAlignment);
  const Result<std::uint64_t> offset = start ? state.append(manifest, kAlignment) : start;
  if (!offset) {
    state.status = offset.error();
    return;
  }
  state.header.manifest_offset = *offset;
  state.header.manifest_size = manifest.size();
  state.header.manifest_checksum = block_checksum(manifest);
}

ContainerWriter::~ContainerWriter() = default;

Result<void> ContainerWriter::add_tile(TileKey key, std::span<const PackedBlock> layers) {
  State& state = *state_;
  if (!state.status) return state.status;
  std::vector<BlockName> required;
  for (const PackedBlock& layer : layers) {
    if (layer.is_required) required.push_back(name_of(layer));
    if (layer.name != kRangeLayer || !state.look_up) continue;
    // A layer of another kind or size is a mistake that readers name; there is no looking up in it.
    if (!add_to_look_up(layer, *state.look_up)) state.look_up.reset();
  }
  state.tile_digests.push_back(tile_digest(key, required));
  const TileContents contents = contents_of(key, state.tile_digests.back(), layers);
  const std::vector<std::byte> encoded = encode_contents(contents);
  const PackedBlock about =
      plain_block(kContentsLayer, kContentsLayerVersion, contents.layers.size(), encoded);
  std::vector<BlockOffset> blocks;
  const auto append = [&](const PackedBlock& layer) -> Result<void> {
    SIGHTLINE_ASSIGN(const BlockOffset block, state.append_block(layer));
    blocks.push_back(block);
    return {};
  };
  Result<void> written = append(about);
  for (const PackedBlock& layer : layers) {
    if (written && !is_derived(layer.name)) written = append(layer);
  }
  if (!written) return written;
  const schema::Digest digest = to_schema(state.tile_digests.back());
  state.tiles.push_back(
      schema::CreateTile(state.builder, key.x, key.y, &digest, state.builder.CreateVector(blocks)));
  return {};
}

Result<void> ContainerWriter::add_section(const PackedBlock& section) {
  State& state = *state_;
  if (!state.status) return state.status;
  if (is_derived(section.name)) return {};
  SIGHTLINE_ASSIGN(const BlockOffset block, state.append_block(section));
  if (section.is_required) state.required_sections.push_back(name_of(section));
  state.sections.push_back(block);
  return {};
}

Result<Digest> ContainerWriter::finish() {
  State& state = *state_;
  if (!state.status) return state.status.error();
  // The root digest comes before the look-up, whose pages it seals.
  for (const FeatureParts& feature : state.features) {
    if (feature.is_required) state.header.incompatible_features |= std::uint64_t{1} << feature.bit;
  }
  state.header.root_digest = root_digest(state.manifest_digest, state.header.incompatible_features,
                                         state.tile_digests, state.required_sections);
  SIGHTLINE_TRY(state.append_look_up());
  const auto sections = state.builder.CreateVector(state.sections);
  const auto features =
      state.builder.CreateVector(append_features(state.features, state.builder, state.header));
  state.builder.Finish(schema::CreateDirectory(state.builder, features,
                                               state.builder.CreateVector(state.tiles), sections));
  SIGHTLINE_TRY(state.append_end(finished(state.builder)));
  return state.header.root_digest;
}

namespace {

Result<void> add_tile(const TileParts& tile, ContainerWriter& writer) {
  std::vector<SelfContainedBlock> layers;
  for (const BlockParts& layer : tile.layers) layers.push_back(packed(layer));
  std::vector<PackedBlock> blocks;
  for (const SelfContainedBlock& layer : layers) blocks.push_back(layer.block);
  return writer.add_tile(tile.key, blocks);
}

}  // namespace

ContainerWriter::Write write_to(std::vector<std::byte>& file) {
  return [&file](std::uint64_t offset, std::span<const std::byte> bytes) {
    if (file.size() < offset + bytes.size()) file.resize(offset + bytes.size());
    std::copy(bytes.begin(), bytes.end(), file.begin() + static_cast<std::ptrdiff_t>(offset));
    return Result<void>();
  };
}

std::vector<std::byte> assemble(const ContainerParts& parts) {
  std::vector<std::byte> file;
  ContainerWriter writer(write_to(file), parts.manifest, parts.features);
  for (const TileParts& tile : parts.tiles) SIGHTLINE_CHECK(add_tile(tile, writer));
  for (const BlockParts& section : parts.sections) {
    SIGHTLINE_CHECK(writer.add_section(packed(section).block));
  }
  SIGHTLINE_CHECK(writer.finish());
  return file;
}

}  // namespace sightline
