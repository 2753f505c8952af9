#include "tests/fuzz/repair_map.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "formats/map/container/packed_block.h"
#include "formats/reader/look_up.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

// A block that unpacks to more than this keeps its digest: a fuzzer has no time for it.
constexpr std::uint64_t kMostUnpacked = std::uint64_t{1} << 20;

std::optional<std::span<std::byte>> part(std::span<std::byte> file, std::uint64_t offset,
                                         std::uint64_t size) {
  if (offset > file.size() || size > file.size() - offset) return {};
  return file.subspan(offset, size);
}

// Reads from a copy of the directory and writes into the file: in a damaged one a digest may lie on
// an offset that has been verified already.
class DirectoryRepair {
 public:
  DirectoryRepair(std::span<std::byte> file, std::span<std::byte> directory)
      : file_(file), written_(directory), read_(directory.begin(), directory.end()) {}

  [[nodiscard]] const schema::Directory* verified() const {
    const auto* data = reinterpret_cast<const std::uint8_t*>(read_.data());
    flatbuffers::Verifier verifier(data, read_.size());
    if (!verifier.VerifyBuffer<schema::Directory>(nullptr)) return nullptr;
    return flatbuffers::GetRoot<schema::Directory>(data);
  }

  Digest repair(const schema::Directory& directory, const FileHeader& header,
                std::span<const std::byte> manifest) {
    std::vector<Digest> tiles;
    for (const schema::Tile* tile : *directory.tiles()) {
      tiles.push_back(tile_digest({tile->x(), tile->y()}, repair_blocks(*tile->layers())));
      store(tile->digest(), tiles.back().data(), tiles.back().size());
    }
    return root_digest(sha256(manifest), header.incompatible_features, tiles,
                       repair_blocks(*directory.sections()));
  }

  // Number, seed and checksum of each page of the section "look-up", under the header's root
  // digest.
  void repair_pages(const schema::Directory& directory, const FileHeader& header) {
    for (const schema::Block* block : *directory.sections()) {
      if (block->name()->string_view() != kLookUpSection) continue;
      const auto stored = part(file_, block->offset(), block->stored_size());
      if (!stored) return;
      for (std::uint64_t number = 0; number < stored->size() / kPageSize; ++number) {
        seal_page(stored->subspan(number * kPageSize, kPageSize), number, page_seed(header));
      }
      repair_block(*block);
    }
  }

 private:
  using Blocks = flatbuffers::Vector<flatbuffers::Offset<schema::Block>>;

  void store(const void* place_in_copy, const void* value, std::size_t size) {
    if (place_in_copy == nullptr) return;
    const auto offset =
        static_cast<std::size_t>(static_cast<const std::byte*>(place_in_copy) - read_.data());
    std::memcpy(written_.subspan(offset, size).data(), value, size);
  }

  BlockName repair_block(const schema::Block& block) {
    Digest raw_digest{};
    std::memcpy(raw_digest.data(), block.raw_digest(), raw_digest.size());
    const auto stored = part(file_, block.offset(), block.stored_size());
    if (stored) {
      const std::uint64_t checksum = block_checksum(*stored);
      const auto* table = reinterpret_cast<const flatbuffers::Table*>(&block);
      store(table->GetAddressOf(schema::Block::VT_STORED_CHECKSUM), &checksum, sizeof checksum);
      if (block.codec() == schema::Codec::None) raw_digest = sha256(*stored);
      if (block.codec() == schema::Codec::Zstd && block.raw_size() <= kMostUnpacked) {
        const Result<std::vector<std::byte>> raw = unpack_zstd(*stored, block.raw_size());
        if (raw) raw_digest = sha256(*raw);
      }
      store(block.raw_digest(), raw_digest.data(), raw_digest.size());
    }
    return {block.name()->str(), block.version(), block.row_count(), raw_digest};
  }

  std::vector<BlockName> repair_blocks(const Blocks& blocks) {
    std::vector<BlockName> required;
    for (const schema::Block* block : blocks) {
      const BlockName name = repair_block(*block);
      if (block->is_required()) required.push_back(name);
    }
    return required;
  }

  std::span<std::byte> file_;
  std::span<std::byte> written_;
  std::vector<std::byte> read_;
};

void repair_contents(std::span<std::byte> file, const std::optional<Digest>& root,
                     FileHeader& header) {
  const auto manifest = part(file, header.manifest_offset, header.manifest_size);
  const auto directory = part(file, header.directory_offset, header.directory_size);
  if (manifest) header.manifest_checksum = block_checksum(*manifest);
  if (!directory) return;
  DirectoryRepair repair(file, *directory);
  const schema::Directory* verified = repair.verified();
  if (manifest && verified != nullptr) {
    header.root_digest = root.value_or(repair.repair(*verified, header, *manifest));
    repair.repair_pages(*verified, header);
  }
  header.directory_checksum = block_checksum(*directory);
}

}  // namespace

void repair_map(std::span<std::byte> file, const std::optional<Digest>& root) {
  if (file.size() < kHeaderSize + kTrailerSize) return;
  FileHeader header = header_fields(file);
  header.file_size = file.size();
  repair_contents(file, root, header);
  const auto start = encode_header(header);
  const auto end = encode_trailer(header, start);
  std::copy(start.begin(), start.end(), file.begin());
  std::copy(end.begin(), end.end(), file.end() - kTrailerSize);
}

}  // namespace sightline
