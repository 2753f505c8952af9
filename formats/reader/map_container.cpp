#include "formats/reader/map_container.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "formats/reader/map_checks.h"
#include "map_generated.h"

namespace sightline {
namespace {

using Blocks = flatbuffers::Vector<flatbuffers::Offset<schema::Block>>;

// A FlatBuffer of our own file: bounds, alignment and checksum first, since the verifier of
// FlatBuffers accepts a flipped bit and a misaligned buffer.
template <class Root>
Result<const Root*> open_buffer(std::span<const std::byte> file, std::uint64_t offset,
                                std::uint64_t size, std::uint64_t checksum, const char* name) {
  if (offset % kAlignment != 0 || offset < kHeaderSize || offset > file.size() - kTrailerSize ||
      size > file.size() - kTrailerSize - offset) {
    return Error{ErrorCode::kOutOfBounds,
                 concat("bytes ", offset, " + ", size, " are misaligned or leave the file"), "",
                 name};
  }
  const std::span<const std::byte> bytes = file.subspan(offset, size);
  if (block_checksum(bytes) != checksum) {
    return Error{ErrorCode::kChecksumMismatch, concat("the ", name, " does not match its checksum"),
                 "", concat("byte ", offset)};
  }
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  constexpr flatbuffers::uoffset_t kDeepest = 16;
  // A table takes at least 4 bytes, so this refuses nothing that could be real.
  const auto most_tables = static_cast<flatbuffers::uoffset_t>(size / 4 + 1);
  flatbuffers::Verifier verifier(data, size, kDeepest, most_tables);
  if (size > FLATBUFFERS_MAX_BUFFER_SIZE || !verifier.VerifyBuffer<Root>(nullptr)) {
    return Error{ErrorCode::kBadManifest, concat("the ", name, " is not a valid FlatBuffer"), "",
                 concat("byte ", offset)};
  }
  return flatbuffers::GetRoot<Root>(data);
}

Result<const schema::Manifest*> open_manifest(std::span<const std::byte> file,
                                              const FileHeader& header) {
  return open_buffer<schema::Manifest>(file, header.manifest_offset, header.manifest_size,
                                       header.manifest_checksum, "manifest");
}

Result<const schema::Directory*> read_directory(std::span<const std::byte> file,
                                                const FileHeader& header) {
  return open_buffer<schema::Directory>(file, header.directory_offset, header.directory_size,
                                        header.directory_checksum, "directory");
}

// A name for people: printable, and no longer than one is.
bool is_name(std::string_view text) {
  constexpr std::size_t kLongestName = 100;
  return !text.empty() && text.size() <= kLongestName &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

// Another major version may lay out everything after the header differently, so the message names
// who wrote the file only where that can still be read.
Error other_version(std::span<const std::byte> file, const FileHeader& header,
                    FormatVersion program) {
  const bool is_later = header.version > program;
  std::string writer = is_later ? "a later program" : "an earlier program";
  const Result<const schema::Manifest*> manifest = open_manifest(file, header);
  if (manifest && is_name((*manifest)->writer()->string_view())) {
    writer = (*manifest)->writer()->str();
  }
  return {is_later ? ErrorCode::kFutureVersion : ErrorCode::kOldVersion,
          "written by " + writer + ", format " + to_string(header.version) +
              ", this program reads " + to_string(program) + ". Compile again, or use that version",
          "", "byte 8"};
}

// Features may change how the rest is laid out: they come before any other complaint.
Result<void> check_required_features(std::span<const std::byte> file, const FileHeader& header) {
  if (header.incompatible_features == 0) return {};
  const Result<const schema::Directory*> directory = read_directory(file, header);
  if (directory) return check_features(header, **directory);
  return Error{ErrorCode::kUnknownRequiredFeature, "required features are unknown to this program",
               "", "byte 24"};
}

const schema::Block* find_block(const Blocks& blocks, std::string_view name) {
  for (const schema::Block* block : blocks) {
    if (block->name()->string_view() == name) return block;
  }
  return nullptr;
}

Result<MapFront> front_behind(const FileHeader& header, std::span<const std::byte> file,
                              FormatVersion program) {
  SIGHTLINE_CHECK(reinterpret_cast<std::uintptr_t>(file.data()) % 8 == 0);
  if (!can_read(program, header.version)) return other_version(file, header, program);
  SIGHTLINE_TRY(check_required_features(file, header));
  SIGHTLINE_ASSIGN(const schema::Manifest* manifest, open_manifest(file, header));
  SIGHTLINE_TRY(check_manifest(*manifest));
  return MapFront{file, header, manifest};
}

}  // namespace

Result<MapFront> open_front(std::span<const std::byte> file, FormatVersion program) {
  SIGHTLINE_ASSIGN(const FileHeader header, decode_header(file));
  return front_behind(header, file, program);
}

Result<MapFront> open_front_alone(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(const FileHeader header, decode_header_alone(file));
  return front_behind(header, file, kFormatVersion);
}

Result<MapContainer> open_directory(const MapFront& front) {
  SIGHTLINE_ASSIGN(const schema::Directory* directory, read_directory(front.file, front.header));
  const MapContainer container{front.file, front.header, front.manifest, directory};
  SIGHTLINE_TRY(check_directory(container));
  return container;
}

Result<MapContainer> open_container(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(const MapFront front, open_front(file));
  return open_directory(front);
}

std::optional<std::uint32_t> find_tile(const MapContainer& container, std::int32_t x,
                                       std::int32_t y) {
  const auto& tiles = *container.directory->tiles();
  std::uint32_t low = 0;
  std::uint32_t high = tiles.size();
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    const schema::Tile* tile = tiles.Get(middle);
    const bool is_before = std::pair(tile->x(), tile->y()) < std::pair(x, y);
    (is_before ? low : high) = is_before ? middle + 1 : middle;
  }
  if (low == tiles.size() || tiles.Get(low)->x() != x || tiles.Get(low)->y() != y) return {};
  return low;
}

const schema::Block* find_layer(const MapContainer& container, std::uint32_t tile,
                                std::string_view name) {
  return find_block(*container.directory->tiles()->Get(tile)->layers(), name);
}

const schema::Block* find_section(const MapContainer& container, std::string_view name) {
  return find_block(*container.directory->sections(), name);
}

std::span<const std::byte> located_bytes(const MapContainer& container,
                                         const schema::Block& block) {
  return container.file.subspan(block.offset(), block.stored_size());
}

Result<std::span<const std::byte>> stored_bytes(const MapContainer& container,
                                                const schema::Block& block) {
  const std::span<const std::byte> bytes = located_bytes(container, block);
  if (block_checksum(bytes) != block.stored_checksum()) {
    return Error{ErrorCode::kChecksumMismatch,
                 "block " + block.name()->str() + " does not match its checksum", "",
                 "byte " + std::to_string(block.offset())};
  }
  return bytes;
}

}  // namespace sightline
