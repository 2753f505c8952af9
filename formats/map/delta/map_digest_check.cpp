#include "formats/map/delta/map_digest_check.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <vector>

#include "formats/map/container/packed_block.h"
#include "formats/reader/map_checks.h"
#include "formats/reader/map_container.h"
#include "formats/reader/mapped_file.h"
#include "map_generated.h"

namespace sightline {
namespace {

using Blocks = flatbuffers::Vector<flatbuffers::Offset<schema::Block>>;

// Pages that were read stay with the process until somebody else needs them: given back at once,
// memory does not grow with the file.
void forget(std::span<const std::byte> bytes) {
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = (reinterpret_cast<std::uintptr_t>(bytes.data()) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(bytes.data()) + bytes.size()) / page * page;
  if (begin >= end) return;
  (void)::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
}

// Goes through the file once, from its beginning to its end.
class DigestCheck {
 public:
  explicit DigestCheck(const MapContainer& map)
      : map_(map), checked_to_(map.header.manifest_offset + map.header.manifest_size) {}

  Result<Digest> run();

 private:
  Result<void> check_block(const schema::Block& block);
  Result<std::vector<BlockName>> check_blocks(const Blocks& blocks, const std::string& owner);

  const MapContainer& map_;
  std::uint64_t checked_to_;
};

Result<void> DigestCheck::check_block(const schema::Block& block) {
  SIGHTLINE_TRY(check_zeros(map_.file, checked_to_, block.offset()));
  checked_to_ = block.offset() + block.stored_size();
  SIGHTLINE_ASSIGN(const std::span<const std::byte> stored, stored_bytes(map_, block));
  if (!block.is_required()) return {};
  Digest digest{};
  if (block.codec() != schema::Codec::None) {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> raw,
                     unpack(static_cast<BlockCodec>(block.codec()), stored, block.row_count(),
                            block.raw_size()));
    digest = sha256(raw);
  } else {
    digest = sha256(stored);
  }
  if (digest != to_digest(*block.raw_digest())) {
    return wrong_digest("block " + block.name()->str(), "byte " + std::to_string(block.offset()));
  }
  return {};
}

Result<std::vector<BlockName>> DigestCheck::check_blocks(const Blocks& blocks,
                                                         const std::string& owner) {
  std::vector<BlockName> required;
  for (const schema::Block* block : blocks) {
    const Result<void> checked = check_block(*block);
    forget(located_bytes(map_, *block));
    if (!checked) {
      Error error = checked.error();
      error.place = owner + block->name()->str() + (error.place.empty() ? "" : ", " + error.place);
      return error;
    }
    if (!block->is_required()) continue;
    required.push_back({block->name()->str(), block->version(), block->row_count(),
                        to_digest(*block->raw_digest())});
  }
  return required;
}

Result<Digest> DigestCheck::run() {
  const FileHeader& header = map_.header;
  SIGHTLINE_TRY(check_zeros(map_.file, kHeaderSize, header.manifest_offset));
  std::vector<Digest> tiles;
  for (const schema::Tile* tile : *map_.directory->tiles()) {
    const std::string place = tile_place(tile->x(), tile->y());
    SIGHTLINE_ASSIGN(const std::vector<BlockName> layers,
                     check_blocks(*tile->layers(), place + " layer "));
    tiles.push_back(tile_digest({tile->x(), tile->y()}, layers));
    if (tiles.back() != to_digest(*tile->digest())) return wrong_digest("the tile", place);
  }
  SIGHTLINE_ASSIGN(const std::vector<BlockName> sections,
                   check_blocks(*map_.directory->sections(), "section "));
  SIGHTLINE_TRY(check_zeros(map_.file, checked_to_, header.directory_offset));
  SIGHTLINE_TRY(check_zeros(map_.file, header.directory_offset + header.directory_size,
                            map_.file.size() - kTrailerSize));
  const Digest manifest = sha256(map_.file.subspan(header.manifest_offset, header.manifest_size));
  const Digest root = root_digest(manifest, header.incompatible_features, tiles, sections);
  if (root != header.root_digest) return wrong_digest("the map", "byte 88");
  return root;
}

}  // namespace

Result<Digest> check_map_digests(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(path.string()));
  const Result<MapContainer> map = open_container(file.bytes());
  Result<Digest> root = map ? DigestCheck(*map).run() : map.error();
  if (root) return root;
  Error error = root.error();
  error.file = path.string();
  return error;
}

}  // namespace sightline
