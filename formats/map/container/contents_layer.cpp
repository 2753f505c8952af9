#include "formats/map/container/contents_layer.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "formats/base/bytes.h"
#include "formats/reader/map_layout.h"
#include "formats/record/codec.h"

namespace sightline {

// Behind name, version, whether it is required and its codec.
SIGHTLINE_SOME_FIELDS(ContentsEntry, row_count, offset, stored_size, raw_size, stored_checksum,
                      raw_digest)

namespace {

using Magic = std::array<std::uint8_t, 8>;
constexpr Magic kMagic = {0x89, 'S', 'L', 'T', '\r', '\n', 0x1A, '\n'};
constexpr std::size_t kHeadSize = 64;
constexpr std::size_t kEntrySize = 128;
constexpr std::size_t kChecked = 16;  // the checksum covers all from here on

std::uint64_t contents_size(std::size_t layer_count) {
  return kHeadSize + kEntrySize * layer_count;
}

bool is_listed(const PackedBlock& layer) {
  return !is_derived(layer.name) && layer.name.size() <= kLongestContentsName;
}

void put_entry(const ContentsEntry& entry, ByteWriter& writer) {
  SIGHTLINE_CHECK(entry.name.size() <= kLongestContentsName);
  std::array<char, kLongestContentsName> name{};
  std::copy(entry.name.begin(), entry.name.end(), name.begin());
  writer.append(name.data(), name.size());
  writer.put(entry.version);
  writer.put(static_cast<std::uint32_t>(entry.is_required));
  writer.put(static_cast<std::uint32_t>(entry.codec));
  writer.put<std::uint32_t>(0);
  encode(entry, writer);
  writer.put<std::uint64_t>(0);
}

ContentsEntry get_entry(std::span<const std::byte> bytes) {
  ContentsEntry entry;
  const auto* name = reinterpret_cast<const char*>(bytes.data());
  entry.name.assign(name, std::find(name, name + kLongestContentsName, '\0'));
  ByteReader reader(bytes.subspan(kLongestContentsName));
  reader.get(entry.version);
  entry.is_required = reader.get<std::uint32_t>() != 0;
  entry.codec = static_cast<BlockCodec>(std::min<std::uint32_t>(reader.get<std::uint32_t>(), 255));
  (void)reader.get<std::uint32_t>();
  decode(reader, entry);
  return entry;
}

}  // namespace

TileContents contents_of(TileKey key, const Digest& digest, std::span<const PackedBlock> layers) {
  TileContents contents{key, digest, {}};
  const auto listed = static_cast<std::size_t>(std::ranges::count_if(layers, is_listed));
  std::uint64_t offset = contents_size(listed);
  for (const PackedBlock& layer : layers) {
    if (is_derived(layer.name)) continue;
    if (is_listed(layer)) {
      contents.layers.push_back({layer.name, layer.version, layer.is_required, layer.codec,
                                 layer.row_count, offset, layer.stored.size(), layer.raw_size,
                                 layer.stored_checksum, layer.raw_digest});
    }
    offset = aligned(offset + layer.stored.size());
  }
  return contents;
}

std::vector<std::byte> encode_contents(const TileContents& contents) {
  constexpr std::uint64_t kNoChecksum = 0;  // until the rest is there
  const auto count = static_cast<std::uint32_t>(contents.layers.size());
  const auto size = static_cast<std::uint32_t>(contents_size(count));
  ByteWriter writer = written(kMagic, kNoChecksum, size, count, contents.key, contents.digest);
  for (const ContentsEntry& entry : contents.layers) put_entry(entry, writer);
  std::vector<std::byte> bytes = writer.take();
  SIGHTLINE_CHECK(bytes.size() == size);
  const std::uint64_t checksum = block_checksum(std::span(bytes).subspan(kChecked));
  std::memcpy(bytes.data() + 8, &checksum, sizeof checksum);
  return bytes;
}

std::optional<TileContents> decode_contents(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeadSize || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    return std::nullopt;
  }
  ByteReader reader(bytes.subspan(kMagic.size()));
  const auto checksum = reader.get<std::uint64_t>();
  const auto size = reader.get<std::uint32_t>();
  const auto count = reader.get<std::uint32_t>();
  if (size != contents_size(count) || size > bytes.size() ||
      block_checksum(bytes.subspan(kChecked, size - kChecked)) != checksum) {
    return std::nullopt;
  }
  TileContents contents;
  decode(reader, contents.key);
  FieldReader(reader).get(contents.digest);
  for (std::uint32_t i = 0; i < count; ++i) {
    contents.layers.push_back(get_entry(bytes.subspan(kHeadSize + kEntrySize * i, kEntrySize)));
  }
  return contents;
}

}  // namespace sightline
