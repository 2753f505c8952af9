#include "tests/fuzz/repair_map.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "compiler/base/bytes.h"
#include "formats/map/block_codec.h"
#include "formats/map/map_digests.h"
#include "formats/reader/look_up.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

// A block that unpacks to more than this keeps its digest: a fuzzer has no time for it.
constexpr std::uint64_t kMostUnpacked = std::uint64_t{1} << 20;

FileHeader fields_of(std::span<const std::byte> file) {
  ByteReader reader(file.subspan(8));
  FileHeader header;
  reader.get(header.major);
  reader.get(header.minor);
  (void)reader.get<std::uint32_t>();
  reader.get(header.compatible_features);
  reader.get(header.incompatible_features);
  reader.get(header.file_size);
  reader.get(header.manifest_offset);
  reader.get(header.manifest_size);
  reader.get(header.manifest_checksum);
  reader.get(header.directory_offset);
  reader.get(header.directory_size);
  reader.get(header.directory_checksum);
  header.file_size = file.size();
  return header;
}

std::optional<std::span<std::byte>> part(std::span<std::byte> file, std::uint64_t offset,
                                         std::uint64_t size) {
  if (offset > file.size() || size > file.size() - offset) return {};
  return file.subspan(offset, size);
}

// The generated accessors only read; the bytes they read are ours to change.
void store(const schema::Digest* place, const Digest& digest) {
  auto* bytes = const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(place));
  std::copy(digest.begin(), digest.end(), bytes);
}

void store_checksum(const schema::Block& block, std::uint64_t checksum) {
  const auto* table = reinterpret_cast<const flatbuffers::Table*>(&block);
  const std::uint8_t* place = table->GetAddressOf(schema::Block::VT_STORED_CHECKSUM);
  if (place != nullptr) std::memcpy(const_cast<std::uint8_t*>(place), &checksum, sizeof checksum);
}

BlockName repair_block(std::span<std::byte> file, const schema::Block& block) {
  const auto stored = part(file, block.offset(), block.stored_size());
  if (stored) {
    store_checksum(block, block_checksum(*stored));
    if (block.codec() == schema::Codec::None) store(block.raw_digest(), sha256(*stored));
    if (block.codec() == schema::Codec::Zstd && block.raw_size() <= kMostUnpacked) {
      const Result<std::vector<std::byte>> raw = unpack_zstd(*stored, block.raw_size());
      if (raw) store(block.raw_digest(), sha256(*raw));
    }
  }
  Digest raw_digest{};
  std::memcpy(raw_digest.data(), block.raw_digest(), raw_digest.size());
  return {block.name()->str(), block.version(), block.row_count(), raw_digest};
}

std::vector<BlockName> repair_blocks(
    std::span<std::byte> file, const flatbuffers::Vector<flatbuffers::Offset<schema::Block>>& all) {
  std::vector<BlockName> required;
  for (const schema::Block* block : all) {
    const BlockName name = repair_block(file, *block);
    if (block->is_required()) required.push_back(name);
  }
  return required;
}

// Of the whole map, which goes into the header.
Digest repair_digests(std::span<std::byte> file, const schema::Directory& directory,
                      const FileHeader& header, std::span<const std::byte> manifest) {
  std::vector<Digest> tiles;
  for (const schema::Tile* tile : *directory.tiles()) {
    tiles.push_back(tile_digest({tile->x(), tile->y()}, repair_blocks(file, *tile->layers())));
    store(tile->digest(), tiles.back());
  }
  return root_digest(sha256(manifest), header.incompatible_features, tiles,
                     repair_blocks(file, *directory.sections()));
}

// Number, seed and checksum of each page of the section "look-up".
void repair_pages(std::span<std::byte> file, const schema::Directory& directory,
                  const FileHeader& header) {
  for (const schema::Block* block : *directory.sections()) {
    if (block->name()->string_view() != kLookUpSection) continue;
    const auto stored = part(file, block->offset(), block->stored_size());
    if (!stored) return;
    for (std::uint64_t number = 0; number < stored->size() / kPageSize; ++number) {
      seal_page(stored->subspan(number * kPageSize, kPageSize), number, page_seed(header));
    }
    repair_block(file, *block);
  }
}

void repair_contents(std::span<std::byte> file, FileHeader& header) {
  const auto manifest = part(file, header.manifest_offset, header.manifest_size);
  const auto directory = part(file, header.directory_offset, header.directory_size);
  if (manifest) header.manifest_checksum = block_checksum(*manifest);
  if (!directory || header.directory_offset % kAlignment != 0) return;
  const auto* data = reinterpret_cast<const std::uint8_t*>(directory->data());
  flatbuffers::Verifier verifier(data, directory->size());
  if (manifest && verifier.VerifyBuffer<schema::Directory>(nullptr)) {
    const auto* root = flatbuffers::GetRoot<schema::Directory>(data);
    header.root_digest = repair_digests(file, *root, header, *manifest);
    repair_pages(file, *root, header);
  }
  header.directory_checksum = block_checksum(*directory);
}

}  // namespace

void repair_map(std::span<std::byte> file) {
  if (file.size() < kHeaderSize + kTrailerSize) return;
  FileHeader header = fields_of(file);
  repair_contents(file, header);
  const auto start = encode_header(header);
  const auto end = encode_trailer(header, start);
  std::copy(start.begin(), start.end(), file.begin());
  std::copy(end.begin(), end.end(), file.end() - kTrailerSize);
}

}  // namespace sightline
